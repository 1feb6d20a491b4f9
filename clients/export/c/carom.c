/* A baked scene in the engine's memory: its words and commands at their samples, and messages while it plays. */
#include "inner.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAGIC "carom 1\n"
#define GRID 256.0 /* to a sample */
#ifndef LAYOUT
#error "expected -DLAYOUT, which names how the engine lays its memory out, as carom export gives it"
#endif

enum { HEAD = 12, LINE = 64, BLOCK = 4096 };

/* The engine: one function over its memory, and one that makes the tables of swarms in it. */
int carom_engine_callback(void *input, void *out, int64_t frames, void *times, int64_t flags, void *state);
void carom_engine_make_pulses(void *state, int64_t number);

int64_t whole_at(const carom *scene, int64_t place) {
    return __atomic_load_n((const int64_t *)(const void *)(scene->state + place), __ATOMIC_ACQUIRE);
}

void whole_put(carom *scene, int64_t place, int64_t number) {
    __atomic_store_n((int64_t *)(void *)(scene->state + place), number, __ATOMIC_RELEASE);
}

static int by_name(const void *a, const void *b) {
    return strcmp(((const field *)a)->name, ((const field *)b)->name);
}

const field *field_of(const carom *scene, const char *prefix, const char *name) {
    char joined[96];
    if (strlen(prefix) + strlen(name) >= sizeof joined) return NULL;
    strcat(strcpy(joined, prefix), name);
    field wanted = {joined, 0, 0};
    return bsearch(&wanted, scene->fields, (size_t)scene->field_count, sizeof wanted, by_name);
}

double field_read(const carom *scene, const uint8_t *command, const char *name) {
    const field *found = field_of(scene, "", name);
    double number = 0.0;
    int64_t whole = 0;
    if (!found) return 0.0;
    memcpy(found->whole ? (void *)&whole : (void *)&number, command + found->place, 8);
    return found->whole ? (double)whole : number;
}

void field_write(const carom *scene, uint8_t *command, const char *prefix, const char *name, double number) {
    const field *found = field_of(scene, prefix, name);
    if (!found) return;
    int64_t whole = found->whole ? (int64_t)number : 0;
    memcpy(command + found->place, found->whole ? (void *)&whole : (void *)&number, 8);
}

int64_t room(const carom *scene) {
    return scene->ring - (scene->inbox_written - __atomic_load_n(&scene->inbox_read, __ATOMIC_ACQUIRE));
}

int post(carom *scene, const uint8_t *command) {
    int64_t written = scene->inbox_written;
    if (room(scene) < 1) return 0;
    memcpy(scene->inbox + written % scene->ring * scene->command_size, command, (size_t)scene->command_size);
    __atomic_store_n(&scene->inbox_written, written + 1, __ATOMIC_RELEASE);
    return 1;
}

/* Give the engine a command. 0: it has no room. */
static int push(carom *scene, const uint8_t *command) {
    int64_t written = whole_at(scene, scene->written);
    if (written - whole_at(scene, scene->read) >= scene->ring) return 0;
    uint8_t *entry = scene->state + scene->entries + written % scene->ring * scene->command_size;
    memcpy(entry, command, (size_t)scene->command_size);
    field_write(scene, entry, "", "number", (double)written);
    whole_put(scene, scene->written, written + 1);
    return 1;
}

/* Give the engine the commands that were sent. */
static void push_sent(carom *scene) {
    int64_t written = __atomic_load_n(&scene->inbox_written, __ATOMIC_ACQUIRE), read = scene->inbox_read;
    while (read < written && push(scene, scene->inbox + read % scene->ring * scene->command_size)) read++;
    __atomic_store_n(&scene->inbox_read, read, __ATOMIC_RELEASE);
}

/* The number and the heads of the runs at a place of the data. */
static const uint32_t *runs_at(const carom *scene, int64_t at) {
    return (const uint32_t *)(const void *)(scene->data + at);
}

static void put_runs(carom *scene, int64_t at) {
    const uint32_t *heads = runs_at(scene, at);
    const uint8_t *words = scene->data + at + 8 + 8 * (int64_t)heads[0];
    for (uint32_t n = 0; n < heads[0]; n++) {
        size_t size = 8 * (size_t)heads[3 + 2 * n];
        memcpy(scene->state + 8 * (int64_t)heads[2 + 2 * n], words, size);
        words += size;
    }
}

/* 1 if the runs at a place of the data lie in it, and change the engine's memory alone. */
static int are_runs(const carom *scene, int64_t at) {
    if (at < 0 || at % 8 || at > scene->data_size - 8) return 0;
    const uint32_t *heads = runs_at(scene, at);
    int64_t used = at + 8 + 8 * (int64_t)heads[0];
    for (uint32_t n = 0; used <= scene->data_size && n < heads[0]; n++) {
        int64_t first = heads[2 + 2 * n], size = heads[3 + 2 * n];
        if (8 * (first + size) > scene->state_size) return 0;
        used += 8 * size;
    }
    return used <= scene->data_size;
}

static int are_commands(const carom *scene, int64_t at, int64_t count) {
    return at >= 0 && at % 8 == 0 && count >= 0 && count <= scene->data_size &&
           at + count * scene->command_size <= scene->data_size;
}

/* Send a command of the data, at its own time, or now. */
static void push_laid(carom *scene, int64_t at, int now) {
    uint8_t *copy = scene->state + scene->state_size; /* room for one, behind the engine's memory */
    memcpy(copy, scene->data + at, (size_t)scene->command_size);
    if (now) field_write(scene, copy, "", "time", -1.0);
    push(scene, copy);
}

static int is_of_engine(const carom *scene, int64_t at) {
    static const char *const kinds[] = {"METHOD", "ACCURACY", "QUALITY", "GAIN", "LIMITER", "BUDGET", "BANK"};
    double kind = field_read(scene, scene->data + at, "kind");
    for (int n = 0; n < 7; n++)
        if (number_of(item(scene->map, "kinds"), kinds[n]) == kind) return 1;
    return 0;
}

/* Make all objects that stay where they were made, and the engine as the first lines have it. */
static void make_all(carom *scene) {
    for (int64_t n = 0; n < scene->batch_count; n++) put_runs(scene, scene->batches[n].runs);
    for (int64_t n = 0; scene->batch_count && n < scene->batches[0].count; n++) {
        int64_t at = scene->batches[0].commands + n * scene->command_size;
        if (is_of_engine(scene, at)) push_laid(scene, at, 0);
    }
    for (const value *each = item(scene->map, "objects")->first; each; each = each->next)
        if (is_true(each, "stays")) push_laid(scene, (int64_t)number_of(each, "made"), 1);
    __atomic_store_n(&scene->next, scene->batch_count, __ATOMIC_RELEASE);
}

/* Give the engine what is due, and compute at most so many frames; how many there are. */
static int64_t compute(carom *scene, float *out, int64_t frames) {
    double times[3] = {0.0, 0.0, 0.0};
    int64_t position = whole_at(scene, scene->position), next = scene->next;
    while (next < scene->batch_count && scene->batches[next].at <= position) {
        const batch *due = &scene->batches[next++];
        put_runs(scene, due->runs);
        for (int64_t n = 0; n < due->count; n++) push_laid(scene, due->commands + n * scene->command_size, 0);
    }
    __atomic_store_n(&scene->next, next, __ATOMIC_RELEASE);
    push_sent(scene);
    if (next < scene->batch_count && scene->batches[next].at - scene->computed < frames)
        frames = scene->batches[next].at - scene->computed;
    if (frames > BLOCK) frames = BLOCK;
    carom_engine_callback(NULL, out, frames, times, 0, scene->state);
    scene->computed += frames;
    return frames;
}

void carom_load(carom *scene, int live) {
    float silence[64 * 8];
    memset(scene->state, 0, (size_t)scene->state_size);
    put_runs(scene, (int64_t)number_of(scene->map, "start"));
    int64_t table = 0;
    for (const value *each = item(scene->map, "pulses")->first; each; each = each->next)
        carom_engine_make_pulses(scene->state, table++);
    scene->next = 0;
    scene->live = live;
    scene->computed = scene->inbox_written = scene->inbox_read = 0;
    scene->told[0] = 0;
    messages_begin(scene);
    if (live) make_all(scene);
    int64_t most = (int64_t)(sizeof silence / sizeof *silence) / scene->channels;
    for (int64_t left = (int64_t)number_of(scene->map, "delay"); left > 0;) /* silence that the limiter begins with */
        left -= compute(scene, silence, left < most ? left : most);
}

void carom_process(carom *scene, float *out, size_t frames) {
    for (size_t done = 0; done < frames;)
        done += (size_t)compute(scene, out + done * (size_t)scene->channels, (int64_t)(frames - done));
}

static int find_fields(carom *scene) {
    const value *fields = item(item(scene->map, "command"), "fields");
    int count = 0;
    for (const value *each = fields->first; each; each = each->next) count++;
    scene->fields = calloc((size_t)count + 1, sizeof *scene->fields);
    if (!scene->fields) return 0;
    for (const value *each = fields->first; each; each = each->next) {
        field found = {each->key, (int64_t)item_at(each, 0)->number, item_at(each, 1)->number != 0.0};
        if (found.place < 0 || found.place > scene->command_size - 8) return 0;
        scene->fields[scene->field_count++] = found;
    }
    qsort(scene->fields, (size_t)scene->field_count, sizeof *scene->fields, by_name);
    return 1;
}

static int find_batches(carom *scene) {
    const value *batches = item(scene->map, "batches");
    int64_t count = 0;
    for (const value *each = batches->first; each; each = each->next) count++;
    scene->batches = calloc((size_t)count + 1, sizeof *scene->batches);
    if (!scene->batches) return 0;
    for (const value *each = batches->first; each; each = each->next) {
        int64_t told[4];
        for (int n = 0; n < 4; n++) told[n] = (int64_t)item_at(each, n)->number;
        if (!are_runs(scene, told[1]) || !are_commands(scene, told[2], told[3])) return 0;
        scene->batches[scene->batch_count++] = (batch){told[0], told[1], told[2], told[3]};
    }
    for (const value *each = item(scene->map, "objects")->first; each; each = each->next)
        if (!are_commands(scene, (int64_t)number_of(each, "made"), 1)) return 0;
    return are_runs(scene, (int64_t)number_of(scene->map, "start"));
}

/* Find the parts of the engine's memory. 0: one does not lie there. */
static int find_places(carom *scene) {
    const value *state = item(scene->map, "state");
    struct {
        const char *name;
        int64_t *place;
    } places[] = {
        {"entries", &scene->entries}, {"written", &scene->written}, {"read", &scene->read},
        {"position", &scene->position}, {"ends", &scene->ends}, {"ended", &scene->ended},
    };
    scene->state_size = (int64_t)number_of(state, "size");
    scene->ring = (int64_t)number_of(state, "ring");
    scene->most_ended = (int64_t)number_of(state, "most_ended");
    scene->command_size = (int64_t)number_of(item(scene->map, "command"), "size");
    scene->channels = (int)number_of(scene->map, "channels");
    scene->rate = number_of(scene->map, "rate");
    for (int n = 0; n < 6; n++) {
        *places[n].place = (int64_t)number_of(state, places[n].name);
        if (*places[n].place <= 0 || *places[n].place > scene->state_size - 8) return 0;
    }
    return scene->state_size < (int64_t)1 << 32 && scene->ring > 0 && scene->most_ended > 0 && scene->channels > 0 &&
           scene->channels <= 8 && scene->command_size > 0 &&
           scene->entries + scene->ring * scene->command_size <= scene->state_size &&
           scene->ends + 16 * scene->most_ended <= scene->state_size;
}

static int opened(carom *scene, const uint8_t *baked, size_t size) {
    uint32_t length;
    if (size < HEAD || memcmp(baked, MAGIC, 8)) return 0;
    memcpy(&length, baked + 8, 4);
    if (length > size - HEAD) return 0;
    scene->data_size = (int64_t)(size - HEAD - length);
    scene->text = malloc((size_t)length + 1);
    scene->data = malloc((size_t)scene->data_size + 8);
    if (!scene->text || !scene->data) return 0;
    memcpy(scene->text, baked + HEAD, length);
    scene->text[length] = 0;
    memcpy(scene->data, baked + HEAD + length, (size_t)scene->data_size);
    scene->map = json_read(scene->text, length);
    if (!scene->map || strcmp(text_of(scene->map, "layout"), LAYOUT)) return 0;
    if (!find_places(scene) || !find_fields(scene) || !find_batches(scene)) return 0;
    scene->memory = calloc(1, (size_t)(scene->state_size + scene->command_size + LINE));
    if (!scene->memory) return 0;
    scene->state = (uint8_t *)scene->memory + (LINE - (uintptr_t)scene->memory % LINE) % LINE;
    scene->object_room = (int)number_of(item(scene->map, "state"), "objects");
    if (scene->object_room < 0 || scene->object_room > 1 << 20) return 0;
    scene->gesture_room = (int)number_of(item(scene->map, "state"), "events");
    if (scene->gesture_room < 0 || scene->gesture_room > 1 << 20) return 0;
    scene->objects = calloc((size_t)scene->object_room + 1, sizeof *scene->objects);
    scene->gestures = malloc(((size_t)scene->gesture_room + 1) * sizeof *scene->gestures);
    scene->inbox = malloc((size_t)(scene->ring * scene->command_size));
    return scene->objects && scene->gestures && scene->inbox;
}

carom *carom_open(const void *baked, size_t size, int live) {
    carom *scene = calloc(1, sizeof *scene);
    if (!scene) return NULL;
    if (!opened(scene, baked, size)) {
        carom_close(scene);
        return NULL;
    }
    carom_load(scene, live);
    return scene;
}

/* The sample of a time: that of the engine's grid, if only rounding lies between. */
static double sample_at(const carom *scene, double at) {
    double sample = at * scene->rate, nearest = floor(sample * GRID + 0.5) / GRID;
    return fabs(sample - nearest) <= 4.0 * (nextafter(sample, INFINITY) - sample) ? nearest : sample;
}

int carom_send(carom *scene, const char *message, double at) {
    return messages_perform(scene, message, at < 0.0 ? -1.0 : sample_at(scene, at));
}

const char *carom_told(const carom *scene) {
    return scene->told;
}

int carom_channels(const carom *scene) {
    return scene->channels;
}

double carom_rate(const carom *scene) {
    return scene->rate;
}

long long carom_frames(const carom *scene) {
    return (long long)number_of(scene->map, "frames");
}

long carom_delay(const carom *scene) {
    return (long)(number_of(scene->map, "delay") + number_of(scene->map, "quantum") - 1.0);
}

const char *carom_object(const carom *scene, int number) {
    return number < 0 ? NULL : item_at(item(scene->map, "objects"), number)->key;
}

double carom_pitch(const carom *scene, int number) {
    double pitch = number < 0 ? 0.0 : number_of(item_at(item(scene->map, "objects"), number), "pitch");
    return pitch > 0.0 ? 69.0 + 12.0 * log2(pitch / 440.0) : NAN;
}

static int64_t told_of(const carom *scene, const char *name) {
    int64_t place = (int64_t)number_of(item(scene->map, "state"), name);
    return place > 0 && place <= scene->state_size - 8 ? whole_at(scene, place) : 0;
}

void carom_report(const carom *scene, carom_state *state) {
    int64_t load = told_of(scene, "load");
    memcpy(&state->load, &load, sizeof load);
    state->frames = (long long)told_of(scene, "position");
    state->contacts = (long)told_of(scene, "active");
    state->sounding = (long)told_of(scene, "sounding");
    state->waiting = (long)told_of(scene, "queued");
    state->dropped = (long)told_of(scene, "dropped");
    state->late = (long)told_of(scene, "late");
}

void carom_close(carom *scene) {
    if (!scene) return;
    json_free(scene->map);
    free(scene->text);
    free(scene->data);
    free(scene->memory);
    free(scene->fields);
    free(scene->batches);
    free(scene->inbox);
    free(scene->objects);
    free(scene->gestures);
    free(scene);
}
