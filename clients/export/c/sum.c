/* SHA-256, as FIPS 180-4 has it: a scene's checksum. */
#include <string.h>

#include "inner.h"

static uint32_t turned(uint32_t x, int by) {
    return x >> by | x << (32 - by);
}

static void add_block(uint32_t *hash, const uint8_t *block) {
    static const uint32_t constants[64] = {
        0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98,
        0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786,
        0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8,
        0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13,
        0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819,
        0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a,
        0x5b9cca4f, 0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7,
        0xc67178f2,
    };
    uint32_t words[64], now[8];
    for (int n = 0; n < 16; n++) {
        const uint8_t *at = block + 4 * n;
        words[n] = (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
    }
    for (int n = 16; n < 64; n++) {
        uint32_t a = words[n - 15], b = words[n - 2];
        words[n] = words[n - 16] + (turned(a, 7) ^ turned(a, 18) ^ a >> 3) + words[n - 7] +
                   (turned(b, 17) ^ turned(b, 19) ^ b >> 10);
    }
    memcpy(now, hash, sizeof now);
    for (int n = 0; n < 64; n++) {
        uint32_t a = now[0], e = now[4];
        uint32_t one = now[7] + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) + ((e & now[5]) ^ (~e & now[6])) +
                       constants[n] + words[n];
        uint32_t other = (turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) +
                         ((a & now[1]) ^ (a & now[2]) ^ (now[1] & now[2]));
        memmove(now + 1, now, 7 * sizeof *now);
        now[4] += one;
        now[0] = one + other;
    }
    for (int n = 0; n < 8; n++) hash[n] += now[n];
}

void sum_begin(sum *of) {
    static const uint32_t first[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    memcpy(of->hash, first, sizeof first);
    of->size = 0;
}

void sum_add(sum *of, const uint8_t *bytes, size_t size) {
    while (size) {
        size_t filled = (size_t)(of->size % 64), taken = size < 64 - filled ? size : 64 - filled;
        memcpy(of->block + filled, bytes, taken);
        of->size += taken;
        bytes += taken;
        size -= taken;
        if (filled + taken == 64) add_block(of->hash, of->block);
    }
}

void sum_end(sum *of, uint8_t *made) {
    uint8_t end[72] = {0x80};
    uint64_t bits = 8 * of->size;
    size_t padding = (size_t)((119 - of->size % 64) % 64) + 1;
    for (int n = 0; n < 8; n++) end[padding + (size_t)n] = (uint8_t)(bits >> (56 - 8 * n));
    sum_add(of, end, padding + 8);
    for (int n = 0; n < 32; n++) made[n] = (uint8_t)(of->hash[n / 4] >> (24 - 8 * (n % 4)));
}
