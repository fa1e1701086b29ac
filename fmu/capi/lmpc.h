/* The learning controller as a static library: no file, clock, thread or environment; everything it
 * needs comes from memory. SI units and radians; x forward, y left, angles positive to the left.
 *
 * A step allocates nothing once the first learned lap is driven, except at the end of a lap, where
 * the lap is kept, and in some of the steps after it, a few dozen at most, which learn from it piece
 * by piece. Saving a state allocates. One controller belongs to one thread at a time; several
 * are independent. Every function may be called in any floating-point state of the processor and
 * leaves it as it was. A thread needs 64 KiB of stack.
 */
#ifndef LMPC_H
#define LMPC_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lmpc_controller lmpc_controller;

/* State in the frame of the track's centre line [m/s, m/s, rad/s, rad, m, m]. */
typedef struct { double v_x, v_y, omega_z, e_psi, s, e_y; } lmpc_state;
/* State with the pose in the global frame [m/s, m/s, rad/s, m, m, rad]. */
typedef struct { double v_x, v_y, omega_z, x, y, psi; } lmpc_global_state;
/* Acceleration and steering angle [m/s^2, rad]. */
typedef struct { double a, delta; } lmpc_input;

typedef struct {
    lmpc_input input;
    int32_t action;        /* 0 initial lap, 1 learned, 2 shifted plan, 3 tracking, 4 braking, 5 recovering */
    int32_t iterations;    /* of the solver */
    int32_t lap;           /* in progress, from 1; 0 before the line is first crossed */
    int32_t lap_finished;  /* 1 if this step finished a lap: then the next two hold */
    int32_t lap_valid;     /* inside the track with complete data */
    double lap_time;       /* [s] */
} lmpc_command;

/* A controller, or NULL with the reason in `error` (always ended by a zero byte).
 * config: TOML; what it leaves out, or all if it is NULL, follows from car and track.
 * car, track: name of one that ships ("barc", "l"), or the text of its file (TOML; tracks also CSV).
 */
lmpc_controller *lmpc_create(const char *config, const char *car, const char *track,
                             char *error, size_t error_size);
void lmpc_free(lmpc_controller *controller);

/* Time from one step to the next [s]: the configuration's, else what follows from car and track. */
double lmpc_period(const lmpc_controller *controller);

/* The command for a measurement taken at `time` [s]; `applied` is the input that acts on the car, or
 * NULL if it is not known. 0, or 1 if an argument is NULL. A measurement that is not finite or not
 * believable still gets a safe command: see `action`. */
int lmpc_step(lmpc_controller *controller, double time, const lmpc_state *state,
              const lmpc_input *applied, lmpc_command *command);
int lmpc_step_global(lmpc_controller *controller, double time, const lmpc_global_state *state,
                     const lmpc_input *applied, lmpc_command *command);

/* Work of the next step that needs no measurement; call it when the command is on its way. Leaving it
 * out changes no command. */
int lmpc_prepare(lmpc_controller *controller);

/* The whole state with all that was learned. Returns the bytes it takes and writes them if `size` is
 * enough; 0 on failure. */
size_t lmpc_save(const lmpc_controller *controller, uint8_t *bytes, size_t size);
/* Goes on from saved bytes, bit for bit. 0, or 1 with the reason in `error`: damaged, or of another
 * configuration, car or track. */
int lmpc_load(lmpc_controller *controller, const uint8_t *bytes, size_t size,
              char *error, size_t error_size);

#ifdef __cplusplus
}
#endif
#endif
