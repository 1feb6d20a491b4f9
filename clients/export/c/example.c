/* Renders a scene's score into a WAV file of float32: example SCENE.carom OUT.wav [MESSAGE]

   With a message, as "/object/bell/impact 2.0", the scene is live, and sounds for three seconds by that message. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "carom.h"

enum { FRAMES = 256 };

static void *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    char *bytes = NULL;
    if (file && !fseek(file, 0, SEEK_END)) {
        *size = (size_t)ftell(file);
        bytes = malloc(*size + 1);
        rewind(file);
        if (bytes && fread(bytes, 1, *size, file) != *size) {
            free(bytes);
            bytes = NULL;
        }
    }
    if (file) fclose(file);
    return bytes;
}

static void put(FILE *file, uint32_t number, int bytes) {
    for (int n = 0; n < bytes; n++) fputc((int)(number >> 8 * n & 255), file);
}

static void write_head(FILE *file, int channels, uint32_t rate, uint32_t frames) {
    uint32_t width = 4 * (uint32_t)channels, size = frames * width;
    fwrite("RIFF", 1, 4, file);
    put(file, 36 + size, 4);
    fwrite("WAVEfmt ", 1, 8, file);
    put(file, 16, 4);
    put(file, 3, 2); /* float32 */
    put(file, (uint32_t)channels, 2);
    put(file, rate, 4);
    put(file, rate * width, 4);
    put(file, width, 2);
    put(file, 32, 2);
    fwrite("data", 1, 4, file);
    put(file, size, 4);
}

int main(int count, char **words) {
    if (count < 3) {
        fprintf(stderr, "usage: example SCENE.carom OUT.wav [MESSAGE]\n");
        return 2;
    }
    size_t size = 0;
    void *baked = read_file(words[1], &size);
    carom *scene = baked ? carom_open(baked, size, count > 3) : NULL;
    free(baked);
    if (!scene) {
        fprintf(stderr, "example: %s: %s\n", words[1], baked ? carom_answer(NULL) : "it can't be read");
        return 1;
    }
    if (count > 3 && !carom_send(scene, words[3], -1.0)) {
        fprintf(stderr, "example: %s\n", carom_answer(scene));
        return 1;
    }
    FILE *file = fopen(words[2], "wb");
    if (!file) {
        perror(words[2]);
        return 1;
    }
    int channels = carom_channels(scene);
    double rate = carom_rate(scene);
    long long left = count > 3 ? (long long)(3.0 * rate) : carom_frames(scene);
    float *out = malloc(FRAMES * (size_t)channels * sizeof *out);
    write_head(file, channels, (uint32_t)rate, (uint32_t)left);
    for (; out && left > 0; left -= FRAMES) {
        size_t frames = left < FRAMES ? (size_t)left : FRAMES;
        carom_process(scene, out, frames);
        fwrite(out, sizeof *out, frames * (size_t)channels, file); /* as a little-endian machine has them */
    }
    free(out);
    carom_close(scene);
    return fclose(file) ? 1 : 0;
}
