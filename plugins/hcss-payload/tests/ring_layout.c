/* Prints offset and size of what hcss_ring.h declares, for comparison with ring.py. */
#include "hcss_ring.h"
#include <stdio.h>

#define PRINT(part, name) \
    printf(#part " " #name " %zu %zu\n", offsetof(struct hcss_ring_##part, name), sizeof(((struct hcss_ring_##part *)0)->name))

int main(void) {
    printf("constants magic %llu 0\nconstants version %d 0\n", (unsigned long long)HCSS_RING_MAGIC, HCSS_RING_VERSION);
    printf("constants line %d 0\nconstants slots %d 0\n", HCSS_RING_LINE, HCSS_RING_MAX_SLOTS);
    printf("header all 0 %zu\nslot all 0 %zu\n", sizeof(struct hcss_ring_header), sizeof(struct hcss_ring_slot));
    PRINT(header, magic), PRINT(header, version), PRINT(header, slots), PRINT(header, bands), PRINT(header, rows);
    PRINT(header, columns), PRINT(header, type), PRINT(header, pid), PRINT(header, frames), PRINT(header, skipped);
    PRINT(header, refused), PRINT(header, stalls), PRINT(header, ready), PRINT(header, stop);
    PRINT(header, refused_pose), PRINT(header, state_number), PRINT(header, letter), PRINT(header, pose_number);
    PRINT(header, pose), PRINT(header, targets), PRINT(header, target);
    PRINT(slot, sequence), PRINT(slot, number), PRINT(slot, pose_number), PRINT(slot, state_number);
    PRINT(slot, pose), PRINT(slot, published_ns);
    return 0;
}
