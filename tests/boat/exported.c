/* Ticks of an exported core for whoever asks: the state comes in at one end and goes out at the other.

   A request is a number of ticks, of eight bytes, and the state; the answer is the status of the
   last tick, likewise, and the state. It ends with its input. */

#include <stdint.h>
#include <stdio.h>

#include "trainer_core.h"

int main(int count, char **words)
{
    static struct trainer_scratch scratch;
    static struct trainer_state state;
    if (count != 3) return 2;
    FILE *in = fopen(words[1], "rb"), *out = fopen(words[2], "wb");
    if (!in || !out) return 2;
    int64_t ticks;
    while (fread(&ticks, sizeof ticks, 1, in) == 1) {
        int64_t status = 0;
        if (fread(&state, sizeof state, 1, in) != 1) return 2;
        while (ticks-- > 0 && status == 0)
            status = trainer_tick(&trainer_vessel, &trainer_compact, &state, &scratch);
        if (fwrite(&status, sizeof status, 1, out) != 1) return 2;
        if (fwrite(&state, sizeof state, 1, out) != 1) return 2;
        if (fflush(out)) return 2;
    }
    return 0;
}
