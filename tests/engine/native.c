/* The door of the engine for browsers, as this machine's own code of the base instruction set: what
 * the module's bytes are compared with.
 * Leaves to others: the requests and the comparison (bits.mjs).
 * Invariant: reads requests of the door's room (length as four bytes, little end first, then the
 * bytes) until the input ends, and writes for each status and bytes as four bytes, then the answer.
 */
#include <assert.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "api/call/call.h"
#include "api/clients/browser/door.h"

static int answer(void) {
    int progress = door_open();
    if (progress < 0) return 0;
    while (progress == API_MORE) progress = door_run();
    assert(progress == API_DONE && door_status() >= 200);
    uint32_t head[2] = {(uint32_t)door_status(), (uint32_t)door_bytes()};
    return fwrite(head, sizeof head, 1, stdout) == 1 &&
           fwrite(door_data(), 1, door_bytes(), stdout) == door_bytes();
}

int main(void) {
    uint32_t bytes;
    while (fread(&bytes, sizeof bytes, 1, stdin) == 1) {
        char *room = door_room(bytes);
        if (!room || fread(room, 1, bytes, stdin) != bytes || !answer()) return EXIT_FAILURE;
        fflush(stdout);
    }
    door_close();
    free(door_room(0));
    return EXIT_SUCCESS;
}
