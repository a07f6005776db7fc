// Asks `hcss serve --name NAME` for the frame of a pose, and prints its mean.
//     c++ -std=c++17 -O2 client.cpp -I"$(hcss serve --include)" -lrt -o client && ./client /NAME T X Y Z QX QY QZ QW
#include "hcss_ring.h"
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <numeric>
#include <thread>
#include <vector>

int main(int count, char **arguments) {
    if (count < 10) return 2;
    const auto nap = std::chrono::microseconds(50);
    hcss_ring_header *ring;
    while (!(ring = hcss_ring_open(arguments[1]))) std::this_thread::sleep_for(nap);
    double pose[8];
    for (int i = 0; i < 8; i++) pose[i] = std::atof(arguments[2 + i]);
    const auto pixels = ring->bands * ring->rows * ring->columns;
    std::vector<char> bytes(hcss_ring_frame_bytes(ring));
    const auto next = hcss_ring_load(&ring->frames), refused = hcss_ring_load(&ring->refused);
    const auto number = hcss_ring_post(ring, pose, nullptr, 0);
    hcss_ring_frame frame{};
    while (!hcss_ring_read(ring, next, &frame, bytes.data()) || frame.pose_number != number) {
        if (!hcss_ring_load(&ring->ready) || hcss_ring_load(&ring->refused) != refused) return 1;
        std::this_thread::sleep_for(nap);
    }
    double sum = 0.0;
    if (ring->type == HCSS_RING_UINT16) {
        const auto values = reinterpret_cast<const std::uint16_t *>(bytes.data());
        sum = std::accumulate(values, values + pixels, 0.0);
    } else {
        const auto values = reinterpret_cast<const float *>(bytes.data());
        sum = std::accumulate(values, values + pixels, 0.0);
    }
    std::cout << "frame " << frame.number << ", state " << frame.state_number << ", mean " << sum / pixels << "\n";
}
