/* Reads COUNT frames of `hcss serve --name NAME`, and prints how late they were and how many were lost.
 *     cc -std=gnu11 -O2 client.c -I"$(hcss serve --include)" -lrt -o client && ./client /NAME COUNT */
#include "hcss_ring.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static int later(const void *a, const void *b) { return (*(double *)a > *(double *)b) - (*(double *)a < *(double *)b); }

int main(int count_of_arguments, char **arguments) {
    if (count_of_arguments < 3) return 2;
    const struct timespec nap = {0, 20000};
    struct hcss_ring_header *ring;
    while (!(ring = hcss_ring_open(arguments[1]))) nanosleep(&nap, NULL);
    long count = atol(arguments[2]), seen = 0, lost = 0;
    double *late_ms = (double *)malloc(count * sizeof(double));
    void *image = malloc(hcss_ring_frame_bytes(ring));
    struct hcss_ring_frame frame;
    uint64_t next = hcss_ring_load(&ring->frames);
    while (seen < count && hcss_ring_load(&ring->ready)) {
        if (!hcss_ring_read(ring, next, &frame, image)) {
            nanosleep(&nap, NULL);
            continue;
        }
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        late_ms[seen++] = 1e-6 * (now.tv_sec * INT64_C(1000000000) + now.tv_nsec - frame.published_ns);
        lost += (long)(frame.number - next);
        next = frame.number + 1;
        /* Use the image here: float or uint16_t, bands x rows x columns. */
    }
    if (!seen) return 1;
    qsort(late_ms, seen, sizeof(double), later);
    printf("%ld frames, %ld lost; from publication to read p50 %.3f, p99 %.3f ms; state %lu\n", seen, lost,
           late_ms[seen / 2], late_ms[seen * 99 / 100], (unsigned long)frame.state_number);
    return 0;
}
