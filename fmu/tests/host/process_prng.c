/* For wine 8 in tests only, never shipped: the one function of bcryptprimitives.dll that Rust's
 * standard library imports and that wine does not have. */
#include <stddef.h>
#include <windows.h>
#include <ntsecapi.h>

__declspec(dllexport) BOOL WINAPI ProcessPrng(unsigned char *buffer, size_t size) {
    return RtlGenRandom(buffer, (ULONG)size);
}
