/* Opens and plays a scene that is changed at random: mutate SCENE.carom SEED FIRST LAST FRAMES. A line for each change:
   its number, what came of it (r refused, p played, n played and not finite), ms of CPU, what was changed, and the
   reason of a refusal. Half of the changes have a mended checksum. */
#include <stdio.h>
#include <sys/time.h>
#include <time.h>

#include "library.c"

enum { AT_ONCE = 512, LONGEST_PLAY = 5 }; /* frames; s of CPU, after which the program is ended */

static uint64_t state;

static uint64_t drawn(uint64_t below) {
    uint64_t x = state += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (x ^ x >> 31) % below;
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* A place from which on something is changed: in the map, among commands and heads of runs, or anywhere. */
static size_t place(const uint8_t *file, size_t size, const carom *whole) {
    uint32_t length;
    memcpy(&length, file + HEAD - 8, 4);
    switch (drawn(4)) {
    case 0: return HEAD + drawn(length);
    case 1: {
        const batch *of = &whole->batches[drawn((uint64_t)whole->batch_count)];
        return HEAD + length + (size_t)of->commands + drawn((uint64_t)(of->count * whole->command_size) + 8);
    }
    case 2: {
        const batch *of = &whole->batches[drawn((uint64_t)whole->batch_count)];
        int64_t at = drawn(4) ? of->runs : (int64_t)number_of(whole->map, "start");
        return HEAD + length + (size_t)at + drawn(8 + 8 * (uint64_t)runs_at(whole, at)[0] + 256);
    }
    default: return drawn(size);
    }
}

static const char *change(uint8_t *file, size_t *size, const carom *whole) {
    static const double odd[] = {0.0, -1.0, 1.0, 1e300, -1e300, 1e-320, INFINITY, NAN, 4096.0, 1e9, 0.5, 1e-9};
    static const int64_t edges[] = {0, -1, 1, 2, 7, 63, 64, 65, 4095, 4096, 16383, 16384, INT32_MAX, INT64_MAX, INT64_MIN};
    size_t at = place(file, *size, whole);
    uint64_t kind = drawn(10);
    if (at >= *size) at = *size - 1;
    size_t left = *size - at, eighth = at / 8 * 8;
    if (kind < 3) {
        file[at] ^= (uint8_t)(1u << drawn(8));
        return "a bit";
    }
    if (kind < 5) {
        file[at] = (uint8_t)drawn(256);
        return "a byte";
    }
    if (kind == 5 && eighth + 8 <= *size) {
        memcpy(file + eighth, &odd[drawn(sizeof odd / sizeof *odd)], 8);
        return "a real number";
    }
    if (kind == 6 && eighth + 8 <= *size) {
        memcpy(file + eighth, &edges[drawn(sizeof edges / sizeof *edges)], 8);
        return "a whole number";
    }
    if (kind == 7) {
        size_t from = drawn(*size), count = 1 + drawn(64);
        if (count > left) count = left;
        if (count > *size - from) count = *size - from;
        memmove(file + at, file + from, count);
        return "bytes from elsewhere";
    }
    if (kind == 8) {
        for (int n = 0; n < 20 && at + 1 < *size && !(file[at] >= '0' && file[at] <= '9'); n++) at++;
        file[at] = (uint8_t)"0123456789-.eE,[]{}\""[drawn(20)];
        return "a character";
    }
    *size = 1 + drawn(*size);
    return "its end";
}

static void mend(uint8_t *file, size_t size) {
    sum made;
    uint8_t digest[SUM];
    if (size < HEAD) return;
    sum_begin(&made);
    sum_add(&made, file, 8);
    sum_add(&made, file + 8 + SUM, size - 8 - SUM);
    sum_end(&made, digest);
    memcpy(file + 8, digest, SUM);
}

static int is_finite_for(carom *scene, long long frames) {
    static float out[AT_ONCE * 8];
    int sane = 1;
    for (long long left = frames; left > 0; left -= AT_ONCE) {
        size_t now = left < AT_ONCE ? (size_t)left : AT_ONCE;
        carom_process(scene, out, now);
        for (size_t n = 0; n < now * (size_t)carom_channels(scene); n++) sane &= isfinite(out[n]) != 0;
    }
    return sane;
}

/* Frames of bodies that fall, slide and touch, and of copies of them. */
static void touch_bodies(carom *scene) {
    const float up[3] = {0.0f, 0.0f, 1.0f}, along[3] = {1.5f, 0.0f, -1.0f};
    float at[3] = {0.0f, 0.0f, 0.05f};
    carom_send(scene, "/object/new ball.1 ball size 2 material glass pan 1", -1.0);
    int floor = carom_body(scene, "floor"), ball = carom_body(scene, "ball"), box = carom_body(scene, "box");
    int other = carom_body(scene, "ball.1"), ground = carom_body(scene, "ground");
    for (int n = 0; n < 12; n++) {
        at[0] += 0.02f;
        carom_move(scene, ball, at, NULL, along, NULL);
        carom_move(scene, box, at, NULL, along, along);
        carom_move(scene, other, at, NULL, along, NULL);
        if (n % 4 == 0) carom_touch(scene, floor, ball, at, up, NAN, 1.0f, NAN);
        if (n % 4 == 1) carom_touch(scene, ground, other, at, up, 0.1f, NAN, NAN);
        carom_touch(scene, floor, box, at, up, NAN, NAN, 1.5f);
        carom_frame(scene, 1.0 / 60.0);
        is_finite_for(scene, 800);
    }
    carom_send(scene, "/object/ball.1/free", -1.0);
}

static char play(const uint8_t *file, size_t size, int live, long long frames) {
    carom *scene = carom_open(file, size, live);
    if (!scene) return 'r';
    if (frames > carom_frames(scene) && !live) frames = carom_frames(scene);
    for (int n = 0; live && n < 8 && carom_object(scene, n); n++) {
        char message[LONGEST_NAME + 64];
        snprintf(message, sizeof message, "/object/%.200s/%s", carom_object(scene, n), n % 2 ? "note 60 100" : "impact 1");
        carom_send(scene, message, -1.0);
    }
    if (live && carom_body(scene, "ground") >= 0) touch_bodies(scene);
    int sane = is_finite_for(scene, frames);
    carom_close(scene);
    return sane ? 'p' : 'n';
}

int main(int count, char **words) {
    FILE *from = count == 6 ? fopen(words[1], "rb") : NULL;
    if (!from) return 2;
    fseek(from, 0, SEEK_END);
    size_t whole_size = (size_t)ftell(from);
    rewind(from);
    uint8_t *whole = malloc(whole_size), *file = malloc(whole_size);
    if (!whole || !file || fread(whole, 1, whole_size, from) != whole_size) return 2;
    fclose(from);
    carom *scene = carom_open(whole, whole_size, 0);
    if (!scene) return fprintf(stderr, "mutate: %s: %s\n", words[1], carom_answer(NULL)), 1;
    for (int64_t n = atoll(words[3]); n < atoll(words[4]); n++) {
        size_t size = whole_size;
        state = (uint64_t)atoll(words[2]) * 0x10000001b3u + (uint64_t)n;
        memcpy(file, whole, size);
        const char *what = change(file, &size, scene);
        if (n % 2) mend(file, size);
        printf("%lld ", (long long)n);
        fflush(stdout);
        uint8_t *tight = malloc(size); /* so that a sanitizer knows its end */
        memcpy(tight, file, size);
        FILE *kept = getenv("KEPT") ? fopen(getenv("KEPT"), "wb") : NULL; /* the last one, to look at */
        if (kept) fclose((fwrite(tight, 1, size, kept), kept));
        int alike = size == whole_size && !memcmp(file, whole, size);
        setitimer(ITIMER_VIRTUAL, &(struct itimerval){.it_value = {LONGEST_PLAY, 0}}, NULL);
        double before = seconds();
        char made = play(tight, size, n % 4 / 2, atoll(words[5]));
        printf("%c %.0f %s%s: %s\n", made, 1e3 * (seconds() - before), what, alike ? " as before" : "",
               made == 'r' ? carom_answer(NULL) : "");
        fflush(stdout);
        free(tight);
    }
    carom_close(scene);
    free(whole);
    free(file);
    return 0;
}
