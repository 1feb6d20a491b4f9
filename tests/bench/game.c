/* A game of bodies that fall, bounce, slide and roll in a pit, heard by an exported scene: what that costs.

   game SCENE.carom BODIES SECONDS [OUT.f32]: prints, as JSON, the share of a core that Carom takes, its longest frame
   (ms), the memory of the process (MB), touches and blows a second, and what was left out. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "carom.h"

enum { RATE = 60, MOST = 400, STEPS = 4 };
#define GRAVITY 9.81f
#define HALF 2.0f      /* m: half of the pit's width */
#define BOUNCE 0.55f
#define FRICTION 0.3f
#define SHARE 0.12 /* of a core: what the sound may take */
#define KICKED 1.2f    /* times in a second that a body is kicked */

typedef struct {
    float at[3], velocity[3], spin[3], radius;
    int number, rolls; /* it slides if it does not roll */
} ball;

static ball balls[MOST];
static carom *scene;
static long touches;
static unsigned seed = 1;

static float chance(void) {
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) / 16777216.0f;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double spent; /* s: in Carom */

static void said(int taken) {
    if (taken) return;
    fprintf(stderr, "game: %s\n", carom_answer(scene));
    exit(1);
}

static void touch(int a, int b, const float *point, const float *normal, float speed) {
    double begun = now();
    said(carom_touch(scene, a, b, point, normal, NAN, speed, NAN));
    spent += now() - begun;
    touches++;
}

/* Push a ball out of something fixed: depth m, normal towards the ball. The speed at which it came. */
static float land(ball *of, const float *normal, float depth) {
    float along = 0.0f, slip[3], length = 0.0f;
    for (int k = 0; k < 3; k++) along += of->velocity[k] * normal[k];
    for (int k = 0; k < 3; k++) of->at[k] += depth * normal[k];
    if (along >= 0.0f) return -along;
    float back = along < -0.25f ? BOUNCE : 0.0f, pushed = -along * (1.0f + back);
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        slip[k] = of->velocity[k] - along * normal[k] - of->radius * (of->spin[i] * normal[j] - of->spin[j] * normal[i]);
        length += slip[k] * slip[k];
    }
    length = sqrtf(length);
    float most = of->rolls ? length * 2.0f / 7.0f : length, rubbed = fminf(FRICTION * pushed, most);
    for (int k = 0; k < 3; k++) of->velocity[k] += pushed * normal[k] - (length > 0.0f ? rubbed * slip[k] / length : 0.0f);
    for (int k = 0; of->rolls && length > 0.0f && k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        of->spin[k] += 2.5f / of->radius * rubbed / length * (normal[i] * slip[j] - normal[j] * slip[i]);
    }
    return -along;
}

/* Move all bodies by a part of a frame, and report who touches where in its last part. */
static void step(int count, float time, int last, int floor_body, int wall) {
    for (int n = 0; n < count; n++) {
        ball *of = &balls[n];
        of->velocity[2] -= GRAVITY * time;
        for (int k = 0; k < 3; k++) of->at[k] += of->velocity[k] * time;
        if (of->at[2] < of->radius) {
            const float up[3] = {0.0f, 0.0f, 1.0f};
            float speed = land(of, up, of->radius - of->at[2]);
            float point[3] = {of->at[0], of->at[1], 0.0f};
            if (last || speed > 0.25f) touch(floor_body, of->number, point, up, speed);
        }
        for (int side = 0; side < 4; side++) {
            float normal[3] = {0.0f, 0.0f, 0.0f};
            normal[side / 2] = side % 2 ? 1.0f : -1.0f;
            float depth = of->radius - HALF - normal[side / 2] * of->at[side / 2];
            if (depth <= 0.0f) continue;
            float speed = land(of, normal, depth), point[3];
            for (int k = 0; k < 3; k++) point[k] = of->at[k] - of->radius * normal[k];
            if (speed > 0.05f) touch(wall, of->number, point, normal, speed);
        }
    }
    for (int n = 0; n < count; n++)
        for (int m = n + 1; m < count; m++) {
            ball *a = &balls[n], *b = &balls[m];
            float way[3], square = 0.0f, both = a->radius + b->radius, along = 0.0f;
            for (int k = 0; k < 3; k++) way[k] = b->at[k] - a->at[k], square += way[k] * way[k];
            if (square >= both * both || square == 0.0f) continue;
            float length = sqrtf(square), heavy = powf(a->radius / b->radius, 3.0f), share = 1.0f / (1.0f + heavy), point[3];
            for (int k = 0; k < 3; k++) way[k] /= length, along += (a->velocity[k] - b->velocity[k]) * way[k];
            for (int k = 0; k < 3; k++) {
                a->at[k] -= (both - length) * share * way[k];
                b->at[k] += (both - length) * (1.0f - share) * way[k];
                if (along > 0.0f) {
                    a->velocity[k] -= along * (1.0f + BOUNCE) * share * way[k];
                    b->velocity[k] += along * (1.0f + BOUNCE) * (1.0f - share) * way[k];
                }
                point[k] = a->at[k] + a->radius * way[k];
            }
            if (last || along > 0.1f) touch(a->number, b->number, point, way, along);
        }
}

static void kick(ball *of) {
    for (int k = 0; k < 2; k++) of->velocity[k] += 4.0f * (chance() - 0.5f);
    if (chance() < 0.7f) of->velocity[2] += 2.0f + 2.0f * chance();
}

static char *content(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*size);
    if (fread(bytes, 1, *size, file) != *size) *size = 0;
    fclose(file);
    return bytes;
}

int main(int count, char **words) {
    if (count < 4) return 2;
    size_t size = 0;
    char *baked = content(words[1], &size);
    int most = atoi(words[2]), frames = RATE * atoi(words[3]);
    scene = baked ? carom_open(baked, size, 1) : NULL;
    if (!scene || most > MOST) {
        fprintf(stderr, "game: %s\n", carom_answer(NULL));
        return 1;
    }
    free(baked);
    FILE *out = count > 4 ? fopen(words[4], "wb") : NULL;
    static const char *const kinds[] = {"ball", "crate", "slab"}, *const materials[] = {"wood", "steel", "glass"};
    float out_of[3] = {0.0f, -2.5f, 1.5f}, right[3] = {1.0f, 0.0f, 0.0f};
    said(carom_listen(scene, out_of, right));
    said(carom_govern(scene, SHARE));
    for (int n = 0; n < most; n++) {
        char message[128], name[32];
        int kind = n % 3;
        double larger = 0.6 + 0.9 * chance();
        snprintf(name, sizeof name, "body.%d", n);
        snprintf(message, sizeof message, "/object/new %s %s size %.3f material %s", name, kinds[kind], larger, materials[n / 3 % 3]);
        said(carom_send(scene, message, -1.0));
        balls[n] = (ball){.radius = (float)(0.04 * larger), .number = carom_body(scene, name), .rolls = kind == 0};
        for (int k = 0; k < 3; k++) balls[n].at[k] = k < 2 ? 2.0f * (HALF - 0.1f) * (chance() - 0.5f) : 0.2f + 2.0f * chance();
    }
    int floor_body = carom_body(scene, "ground"), wall = floor_body, channels = carom_channels(scene);
    size_t length = (size_t)(carom_rate(scene) / RATE);
    float *sound = malloc(length * (size_t)channels * sizeof *sound), peak = 0.0f;
    double longest = 0.0, began = 0.0;
    carom_contacts before = {0};
    for (int frame = -RATE; frame < frames; frame++) { /* the first second is not counted */
        if (frame == 0) carom_report_contacts(scene, &before), touches = 0, began = spent;
        double was = spent;
        for (int n = 0; n < most; n++)
            if (chance() < KICKED / RATE) kick(&balls[n]);
        for (int part = 0; part < STEPS; part++) step(most, 1.0f / RATE / STEPS, part == STEPS - 1, floor_body, wall);
        double begun = now();
        for (int n = 0; n < most; n++) said(carom_move(scene, balls[n].number, balls[n].at, NULL, balls[n].velocity, balls[n].spin));
        said(carom_frame(scene, 1.0 / RATE));
        carom_process(scene, sound, length);
        spent += now() - begun;
        if (frame >= 0) longest = fmax(longest, spent - was);
        for (size_t n = 0; n < length * (size_t)channels; n++) peak = fmaxf(peak, fabsf(sound[n]));
        if (out) fwrite(sound, sizeof *sound, length * (size_t)channels, out);
    }
    carom_state state;
    carom_contacts contacts;
    carom_report(scene, &state);
    carom_report_contacts(scene, &contacts);
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    double seconds = (double)frames / RATE;
    printf("{\"share\": %.4f, \"longest\": %.3f, \"megabytes\": %.1f, \"touches\": %.0f, \"blows\": %.0f, \"faint\": %.0f, "
           "\"slides\": %.1f, \"left_out\": %ld, \"loudest_left_out\": %.1f, \"dropped\": %ld, \"late\": %ld, \"refused\": %ld, "
           "\"crowded\": %ld, \"bodies\": %ld, \"peak\": %.3f}\n",
           (spent - began) / seconds, 1e3 * longest, (double)used.ru_maxrss / 1024.0, (double)touches / seconds,
           (double)(contacts.blows - before.blows) / seconds, (double)(contacts.faint - before.faint) / seconds,
           (double)(contacts.slides - before.slides) / seconds, contacts.left_out, contacts.loudest, state.dropped, state.late,
           state.refused, contacts.crowded, contacts.bodies, (double)peak);
    free(sound);
    carom_close(scene);
    if (out) fclose(out);
    return 0;
}
