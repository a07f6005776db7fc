/* The shared memory of `hcss serve`: a ring of frames, and a letter box for poses; for C11 and C++11.
 *
 * The memory begins with struct hcss_ring_header; behind it, aligned to 64 bytes, each slot of the ring has a
 * struct hcss_ring_slot and its frame, aligned too: bands x rows x columns of float or uint16_t, the upper row first.
 *
 * Sequence numbers are odd while their part is written. A reader loads the number (acquire), copies, and loads it again
 * behind an acquire fence: if it is even and the same, the copy is whole. A writer stores the odd number, a release fence,
 * its part, and the even number (release). Nobody waits for a lock, so a process that dies leaves the others alone.
 * The server runs on processors that store in order (x86-64).
 *
 * `hcss serve --include` prints the folder of this file. Units: seconds, metres (Earth-fixed), W m-2 sr-1. */
#ifndef HCSS_RING_H
#define HCSS_RING_H

#include <stddef.h>
#include <string.h>
#ifdef __cplusplus
#include <atomic>
#include <cstdint>
#define HCSS_STD(name) std::name
#define HCSS_ASSERT(condition, text) static_assert(condition, text)
typedef std::atomic<std::uint64_t> hcss_count;
#else
#include <stdatomic.h>
#include <stdint.h>
#define HCSS_STD(name) name
#define HCSS_ASSERT(condition, text) _Static_assert(condition, text)
typedef _Atomic uint64_t hcss_count;
#endif

#define HCSS_RING_MAGIC UINT64_C(0x686373736C697665)
#define HCSS_RING_VERSION 4
#define HCSS_RING_LINE 64          /* bytes to which parts are aligned */
#define HCSS_RING_MAX_SLOTS 1024
#define HCSS_RING_MAX_TARGETS 64
#define HCSS_RING_MAX_BANDS 16
#define HCSS_RING_TARGET_VALUES 6  /* latitude, longitude (degrees), altitude, velocity toward east, north, up */
#define HCSS_RING_FLOAT 0          /* types of frames: radiance (float), */
#define HCSS_RING_UINT16 1         /* or digital numbers (uint16_t) */

struct hcss_ring_header {
    uint64_t magic, version, slots, bands, rows, columns, type, pid;
    hcss_count frames;             /* published so far; the newest is in slot (frames - 1) % slots */
    hcss_count skipped, refused, stalls; /* poses that newer ones replaced, refused poses, late tiles of the sky */
    hcss_count ready;              /* 0 before the first frame and after the end of the server */
    hcss_count stop;               /* 1 ends the server */
    hcss_count refused_pose;       /* number of the last refused pose */
    hcss_count state_number;       /* of assimilated images that the newest frame shows; 0: the scenario alone */
    hcss_count letter;             /* sequence number of the letter box, which is the rest */
    uint64_t pose_number;          /* a label that the client chooses */
    double pose[8];                /* time, position x y z, quaternion x y z w of the camera's body */
    int64_t targets;               /* number of point targets of this pose; -1: those of the server */
    double target[HCSS_RING_MAX_TARGETS][HCSS_RING_TARGET_VALUES + HCSS_RING_MAX_BANDS]; /* then W sr-1 of each band */
};

struct hcss_ring_slot {
    hcss_count sequence;
    uint64_t number, pose_number, state_number; /* of the frame, from 0; of its pose; of the state of the scene */
    double pose[8];
    int64_t published_ns;          /* on the clock CLOCK_MONOTONIC */
};

HCSS_ASSERT(sizeof(hcss_count) == 8, "counts are plain 64-bit numbers");
HCSS_ASSERT(offsetof(struct hcss_ring_header, frames) == 64, "layout of version 4");
HCSS_ASSERT(offsetof(struct hcss_ring_header, letter) == 128, "layout of version 4");
HCSS_ASSERT(offsetof(struct hcss_ring_header, pose) == 144, "layout of version 4");
HCSS_ASSERT(offsetof(struct hcss_ring_header, target) == 216, "layout of version 4");
HCSS_ASSERT(sizeof(struct hcss_ring_header) == 11480, "layout of version 4");
HCSS_ASSERT(offsetof(struct hcss_ring_slot, pose) == 32, "layout of version 4");
HCSS_ASSERT(sizeof(struct hcss_ring_slot) == 104, "layout of version 4");

static inline uint64_t hcss_ring_load(const hcss_count *count) {
    return HCSS_STD(atomic_load_explicit)(count, HCSS_STD(memory_order_acquire));
}

static inline size_t hcss_ring_up(size_t size) {
    return (size + HCSS_RING_LINE - 1) / HCSS_RING_LINE * HCSS_RING_LINE;
}

/* Bytes of a frame. */
static inline size_t hcss_ring_frame_bytes(const struct hcss_ring_header *ring) {
    return ring->bands * ring->rows * ring->columns * (ring->type == HCSS_RING_UINT16 ? 2 : 4);
}

/* Whether memory of a size is that of a server of this version, with its first frame computed. */
static inline int hcss_ring_is_ready(const struct hcss_ring_header *ring, size_t size) {
    if (size < sizeof *ring || hcss_ring_load(&ring->ready) == 0 || ring->magic != HCSS_RING_MAGIC || ring->version != HCSS_RING_VERSION ||
        ring->slots < 4 || ring->slots > HCSS_RING_MAX_SLOTS || ring->type > HCSS_RING_UINT16 ||
        ring->bands > UINT32_MAX || ring->rows > UINT32_MAX || ring->columns > UINT32_MAX)
        return 0;
    /* In floating point, so that absurd sizes cannot overflow. */
    double frame = 4.0 * (double)ring->bands * (double)ring->rows * (double)ring->columns;
    if (frame > 4.0 * (double)size) return 0;
    size_t slot = hcss_ring_up(sizeof(struct hcss_ring_slot)) + hcss_ring_up(hcss_ring_frame_bytes(ring));
    return hcss_ring_up(sizeof *ring) + ring->slots * slot <= size;
}

static inline const struct hcss_ring_slot *hcss_ring_slot_of(const struct hcss_ring_header *ring, uint64_t number) {
    size_t size = hcss_ring_up(sizeof(struct hcss_ring_slot)) + hcss_ring_up(hcss_ring_frame_bytes(ring));
    return (const struct hcss_ring_slot *)((const char *)ring + hcss_ring_up(sizeof *ring) + number % ring->slots * size);
}

/* What a slot says of its frame, without the sequence number. */
struct hcss_ring_frame {
    uint64_t number, pose_number, state_number;
    double pose[8];
    int64_t published_ns;
};

/* Copy the newest frame if its number is `next` or later: 1. Otherwise, or if it is just being replaced: 0. */
static inline int hcss_ring_read(const struct hcss_ring_header *ring, uint64_t next, struct hcss_ring_frame *frame,
                                 void *image) {
    uint64_t frames = hcss_ring_load(&ring->frames);
    if (frames == 0 || frames - 1 < next) return 0;
    const struct hcss_ring_slot *slot = hcss_ring_slot_of(ring, frames - 1);
    uint64_t before = hcss_ring_load(&slot->sequence);
    if (before % 2) return 0;
    memcpy(image, (const char *)slot + hcss_ring_up(sizeof *slot), hcss_ring_frame_bytes(ring));
    memcpy(frame, (const char *)slot + offsetof(struct hcss_ring_slot, number), sizeof *frame);
    HCSS_STD(atomic_thread_fence)(HCSS_STD(memory_order_acquire));
    return HCSS_STD(atomic_load_explicit)(&slot->sequence, HCSS_STD(memory_order_relaxed)) == before;
}

/* Ask for the frame of a pose, in place of one that the server has not begun, and return its number; for one client. */
static inline uint64_t hcss_ring_post(struct hcss_ring_header *ring, const double pose[8], const double *targets,
                                      int64_t count) {
    uint64_t writing = (hcss_ring_load(&ring->letter) + 1) | 1; /* also after a client that died while it wrote */
    HCSS_STD(atomic_store_explicit)(&ring->letter, writing, HCSS_STD(memory_order_relaxed));
    HCSS_STD(atomic_thread_fence)(HCSS_STD(memory_order_release));
    memcpy(ring->pose, pose, sizeof ring->pose);
    ring->targets = targets ? count : -1;
    for (int64_t i = 0; targets && i < count && i < HCSS_RING_MAX_TARGETS; i++)
        memcpy(ring->target[i], targets + i * (int64_t)(HCSS_RING_TARGET_VALUES + ring->bands),
               (HCSS_RING_TARGET_VALUES + ring->bands) * sizeof(double));
    uint64_t number = ++ring->pose_number;
    HCSS_STD(atomic_store_explicit)(&ring->letter, writing + 1, HCSS_STD(memory_order_release));
    return number;
}

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* Return the ring of a ready server by the name of its memory ("/my-camera"); a null pointer if there is none yet. */
static inline struct hcss_ring_header *hcss_ring_open(const char *name) {
    struct stat file;
    void *memory = MAP_FAILED;
    int number = shm_open(name, O_RDWR, 0);
    if (number < 0) return NULL;
    if (fstat(number, &file) == 0 && (size_t)file.st_size >= sizeof(struct hcss_ring_header))
        memory = mmap(NULL, (size_t)file.st_size, PROT_READ | PROT_WRITE, MAP_SHARED, number, 0);
    close(number);
    if (memory == MAP_FAILED) return NULL;
    if (hcss_ring_is_ready((struct hcss_ring_header *)memory, (size_t)file.st_size))
        return (struct hcss_ring_header *)memory;
    munmap(memory, (size_t)file.st_size);
    return NULL;
}
#endif
#endif
