/* Ticks of a shipped object for whoever asks: records come in at one end and go out at the other.

       aarch64-linux-gnu-gcc -O2 -static -o host emulated.c linux-aarch64.o
       qemu-aarch64 ./host SIZE SIZE SIZE SIZE SIZE

   The sizes [bytes] are those of the five records. A request is a number of ticks, of eight bytes,
   and the records; the answer is the status of the last tick, likewise, and the records. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { RECORDS = 5 };

/* The tick of a block of words: addresses of the records and of the chart, the chart's size. */
int trainer_tick_of(void *block);

int main(int count, char **words)
{
    size_t size[RECORDS];
    double no_chart[1] = {0.0};
    struct {
        void *records[RECORDS];
        void *chart;
        double chart_size;
    } block = {.chart = no_chart, .chart_size = 0.0};
    if (count != 1 + RECORDS) return 2;
    for (int i = 0; i < RECORDS; i++) {
        size[i] = strtoul(words[1 + i], NULL, 10);
        block.records[i] = malloc(size[i]);
        if (!block.records[i]) return 2;
    }
    int64_t ticks;
    while (fread(&ticks, sizeof ticks, 1, stdin) == 1) {
        int64_t status = 0;
        for (int i = 0; i < RECORDS; i++)
            if (fread(block.records[i], 1, size[i], stdin) != size[i]) return 2;
        while (ticks-- > 0 && status == 0) status = trainer_tick_of(&block);
        if (fwrite(&status, sizeof status, 1, stdout) != 1) return 2;
        for (int i = 0; i < RECORDS; i++)
            if (fwrite(block.records[i], 1, size[i], stdout) != size[i]) return 2;
        if (fflush(stdout)) return 2;
    }
    return 0;
}
