/* The controller drives a kinematic car around the small track, in C and from memory alone.
 *
 *     cc example.c -I. -L<folder of liblmpc_c.a> -llmpc_c -lgcc_eh -lpthread -ldl -lm -o example
 *
 * A target that cannot load shared objects links the library whole; what the library asks of its
 * system is memory (malloc), threads' local storage and libm's rounding functions.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lmpc.h"

static const double WHEELBASE = 0.26;

/* One period [s] of a bicycle without slip, in a hundred steps. */
static void drive(lmpc_global_state *x, const lmpc_input *u, double period) {
    for (int i = 0; i < 100; i++) {
        const double h = period / 100;
        x->omega_z = x->v_x / WHEELBASE * tan(u->delta);
        x->v_y = x->omega_z * WHEELBASE / 2;
        x->x += h * (x->v_x * cos(x->psi) - x->v_y * sin(x->psi));
        x->y += h * (x->v_x * sin(x->psi) + x->v_y * cos(x->psi));
        x->psi += h * x->omega_z;
        x->v_x = fmax(x->v_x + h * u->a, 0);
    }
}

int main(void) {
    char error[512];
    const char *settings = "preset = \"race\"\n[warm_up]\nlaps = 2\n";
    lmpc_controller *controller = lmpc_create(settings, "barc", "l", error, sizeof error);
    if (!controller) {
        fprintf(stderr, "%s\n", error);
        return 1;
    }
    const double period = lmpc_period(controller);
    lmpc_global_state x = {1.2, 0, 0, 0, 0, 0};
    lmpc_command command;
    unsigned char *saved = NULL;
    size_t size = 0;
    int laps = 0;
    for (int k = 0; k < 600 && laps < 5; k++) {
        if (lmpc_step_global(controller, k * period, &x, NULL, &command)) return 1;
        drive(&x, &command.input, period);
        lmpc_prepare(controller);
        if (command.lap_finished) {
            laps++;
            printf("lap %d: %.3f s%s\n", laps, command.lap_time, command.lap_valid ? "" : ", not valid");
        }
        /* After the third lap: away with the controller, and on from its bytes. */
        if (command.lap_finished && laps == 3) {
            size = lmpc_save(controller, NULL, 0);
            saved = malloc(size);
            if (!saved || lmpc_save(controller, saved, size) != size) return 1;
            lmpc_free(controller);
            controller = lmpc_create(settings, "barc", "l", error, sizeof error);
            if (!controller || lmpc_load(controller, saved, size, error, sizeof error)) {
                fprintf(stderr, "%s\n", error);
                return 1;
            }
        }
    }
    /* Damaged bytes are refused. */
    if (saved) saved[size - 1] ^= 1;
    if (!saved || !lmpc_load(controller, saved, size, error, sizeof error)) return 1;
    printf("damaged bytes: %s\n", error);
    free(saved);
    lmpc_free(controller);
    return laps == 5 ? 0 : 1;
}
