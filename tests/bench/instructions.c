/* Ticks of the shipped object on records from a file, for a counter of instructions.

       cc -O2 -o host instructions.c linux-x86_64.o
       valgrind --tool=callgrind ./host records.bin 1000 SIZE SIZE SIZE SIZE SIZE

   The sizes [bytes] are those of the five records, which follow one another in the file. */

#include <stdio.h>
#include <stdlib.h>

int trainer_update(void *vessel, void *compact, void *scheme, void *state, void *scratch);

int main(int count, char **words)
{
    void *records[5];
    FILE *file = count == 8 ? fopen(words[1], "rb") : NULL;
    if (!file) return 2;
    for (int i = 0; i < 5; i++) {
        size_t size = strtoul(words[3 + i], NULL, 10);
        records[i] = malloc(size);
        if (!records[i] || fread(records[i], 1, size, file) != size) return 2;
    }
    for (long left = strtol(words[2], NULL, 10); left > 0; left--)
        if (trainer_update(records[0], records[1], records[2], records[3], records[4])) return 1;
    return 0;
}
