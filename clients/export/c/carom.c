/* A baked scene in the engine's memory: its words and commands at their samples, and messages while it plays. */
#include "inner.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "words.h"

#define MAGIC "carom 2\n"
#define GRID 256.0 /* to a sample */
#define MANY 9007199254740992.0

enum { SUM = 32, HEAD = 8 + SUM + 8, LINE = 64, BLOCK = 4096 }; /* LINE: bytes of a cache line */
enum { BEGIN, MAY_START, MAY_WRITE, WRONG_WORD, WRONG_RECORD }; /* questions to the engine: dsp/runtime/admission.py */

static _Thread_local char unopened[512]; /* why the last scene was not */

const value *part(const carom *scene, const char *name) {
    const value *found = item(scene->rules, name);
    return found->kind == NOTHING ? item(scene->map, name) : found;
}

int64_t whole_in(carom *scene, const value *of, const char *name, double low, double high) {
    double number = of->number;
    if (of->kind != NUMBER || !(number >= low && number <= high) || number != floor(number))
        refuse(scene, "%s = %g: expected a whole number, %.16g to %.16g", name, number, low, high);
    return (int64_t)number;
}

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

void expect_command(carom *scene, const uint8_t *command) {
    int64_t wrong = carom_engine_judge(scene->state, command, scene->tables);
    if (wrong < 0) return;
    for (int n = 0; n < scene->field_count; n++)
        if (scene->fields[n].place == 8 * wrong)
            refuse(scene, "a command's %s = %g: none that the engine can take", scene->fields[n].name,
                   field_read(scene, command, scene->fields[n].name));
    refuse(scene, "a command's word %lld: none that the engine can take", (long long)wrong);
}

static void count_refused(carom *scene) {
    __atomic_store_n(&scene->left_out, scene->left_out + 1, __ATOMIC_RELAXED);
}

/* Give the engine a command, or count it if it can't take it. 0: it has no room. */
static int push(carom *scene, const uint8_t *command) {
    int64_t written = whole_at(scene, scene->written);
    if (carom_engine_judge(scene->state, command, scene->tables) >= 0) {
        count_refused(scene);
        return 1;
    }
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

/* Write the runs at a place of the data into the engine's memory, but what it does not let go now. */
static void put_runs(carom *scene, int64_t at, int question) {
    const uint32_t *heads = runs_at(scene, at);
    const uint8_t *words = scene->data + at + 8 + 8 * (int64_t)heads[0];
    for (uint32_t n = 0; n < heads[0]; n++) {
        uint32_t first = heads[2 + 2 * n], count = heads[3 + 2 * n];
        if (carom_engine_ask(scene->state, question, first, count) < 0)
            memcpy(scene->state + 8 * (int64_t)first, words, 8 * (size_t)count);
        words += 8 * (size_t)count;
    }
}

/* Expect that the runs at a place of the data lie in it, and write into the engine's memory what may be there. */
static void expect_runs(carom *scene, int64_t at, int question) {
    if (at % 8) refuse(scene, "runs at %lld: expected a multiple of 8", (long long)at);
    const uint32_t *heads = runs_at(scene, at);
    int64_t used = at + 8 + 8 * (int64_t)heads[0];
    for (uint32_t n = 0; used <= scene->data_size && n < heads[0]; n++) {
        int64_t first = heads[2 + 2 * n], count = heads[3 + 2 * n];
        if (used + 8 * count > scene->data_size) break;
        int64_t wrong = 8 * (first + count) > scene->state_size
                            ? first
                            : carom_engine_ask(scene->state, question, first, count);
        if (wrong < 0) {
            memcpy(scene->state + 8 * first, scene->data + used, 8 * (size_t)count);
            wrong = carom_engine_ask(scene->state, WRONG_WORD, first, count);
        }
        if (wrong >= 0) refuse(scene, "word %lld of the memory: none that a scene has there", (long long)wrong);
        used += 8 * count;
        if (n + 1 == heads[0]) return;
    }
    if (heads[0] || used > scene->data_size) refuse(scene, "runs at %lld: they go beyond the data", (long long)at);
}

static void expect_records(carom *scene) {
    const value *state = item(scene->rules, "state");
    int64_t values = (scene->state_size - (int64_t)number_of(state, "values")) / 4;
    int64_t plates = scene->state_size >= (int64_t)number_of(state, "pulses");
    int64_t wrong = carom_engine_ask(scene->state, WRONG_RECORD, values > 0 ? values : 0, plates);
    if (wrong >= 0) refuse(scene, "record %lld of plates, strikers and pulses: it does not fit itself", (long long)wrong);
}

/* Send a command of the data, at its own time, or now. */
static void push_laid(carom *scene, int64_t at, int now) {
    uint8_t *copy = scene->state + scene->state_size; /* room for one, behind the engine's memory */
    memcpy(copy, scene->data + at, (size_t)scene->command_size);
    if (now) field_write(scene, copy, "", "time", -1.0);
    if (!push(scene, copy)) count_refused(scene);
}

static int is_of_engine(const carom *scene, int64_t at) {
    static const char *const kinds[] = {"ACCURACY", "QUALITY", "GAIN", "LIMITER", "HEADROOM", "BUDGET", "BANK"};
    double kind = field_read(scene, scene->data + at, "kind");
    for (size_t n = 0; n < sizeof kinds / sizeof *kinds; n++)
        if (number_of(item(scene->rules, "kinds"), kinds[n]) == kind) return 1;
    return 0;
}

/* Make all objects that stay where they were made, and the engine as the first lines have it. */
static void make_all(carom *scene) {
    for (int64_t n = 0; n < scene->batch_count; n++) put_runs(scene, scene->batches[n].runs, MAY_WRITE);
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
        put_runs(scene, due->runs, MAY_WRITE);
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

/* Zeros at a multiple of LINE; they take no memory until something is written. Those of before go. */
uint8_t *zeros(void **memory, size_t size) {
    void *fresh = calloc(1, size + LINE);
    if (fresh) free(*memory);
    if (fresh) *memory = fresh;
    if (!*memory) return NULL;
    uint8_t *aligned = (uint8_t *)*memory + (LINE - (uintptr_t)*memory % LINE) % LINE;
    return fresh ? aligned : memset(aligned, 0, size);
}

/* Make the engine's memory one in which nothing has been yet. */
static void begin_memory(carom *scene) {
    const value *state = item(scene->rules, "state");
    scene->state = zeros(&scene->memory, (size_t)(scene->state_size + scene->command_size));
    if (!scene->state) refuse(scene, "no memory is left");
    carom_engine_ask(scene->state, BEGIN, 0, 0);
    memcpy(scene->state + (int64_t)number_of(state, "rate"), &scene->rate, sizeof scene->rate);
    whole_put(scene, (int64_t)number_of(state, "channels"), scene->channels - scene->sensors);
    whole_put(scene, (int64_t)number_of(state, "sensors"), scene->sensors);
    whole_put(scene, (int64_t)number_of(state, "delay"), (int64_t)number_of(scene->map, "delay"));
}

void carom_load(carom *scene, int live) {
    float silence[64 * 8];
    begin_memory(scene);
    put_runs(scene, (int64_t)number_of(scene->map, "start"), MAY_START);
    for (int64_t table = 0; table < scene->tables; table++) carom_engine_make_pulses(scene->state, table);
    scene->next = 0;
    scene->live = live;
    scene->computed = scene->left_out = scene->lost = scene->inbox_written = scene->inbox_read = 0;
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

static void find_fields(carom *scene) {
    const value *fields = item(item(scene->rules, "command"), "fields");
    int count = 0;
    for (const value *each = fields->first; each; each = each->next) count++;
    scene->fields = calloc((size_t)count + 1, sizeof *scene->fields);
    if (!scene->fields) refuse(scene, "no memory is left");
    for (const value *each = fields->first; each; each = each->next)
        scene->fields[scene->field_count++] =
            (field){each->key, (int64_t)item_at(each, 0)->number, item_at(each, 1)->number != 0.0};
    qsort(scene->fields, (size_t)scene->field_count, sizeof *scene->fields, by_name);
}

/* Find the parts of the engine's memory, and make it. */
static void find_places(carom *scene) {
    const value *state = item(scene->rules, "state"), *rates = item(scene->rules, "rates"), *rate = item(scene->map, "rate");
    struct {
        const char *name;
        int64_t *place;
    } places[] = {
        {"entries", &scene->entries}, {"written", &scene->written}, {"read", &scene->read},
        {"position", &scene->position}, {"ends", &scene->ends}, {"ended", &scene->ended},
        {"ring", &scene->ring}, {"most_ended", &scene->most_ended},
    };
    for (int n = 0; n < 8; n++) *places[n].place = (int64_t)number_of(state, places[n].name);
    double most = number_of(state, "most_channels"), quantum = number_of(scene->rules, "quantum");
    scene->command_size = (int64_t)number_of(item(scene->rules, "command"), "size");
    scene->object_room = (int)number_of(state, "objects");
    scene->gesture_room = (int)number_of(state, "events");
    scene->state_size = whole_in(scene, item(scene->map, "size"), "size", number_of(state, "plates"), number_of(state, "most"));
    scene->sensors = (int)whole_in(scene, item(scene->map, "sensors"), "sensors", 0.0, most - 1.0);
    scene->channels = (int)whole_in(scene, item(scene->map, "channels"), "channels", scene->sensors + 1.0, most);
    scene->rate = rate->number;
    if (rate->kind != NUMBER || !(scene->rate >= item_at(rates, 0)->number && scene->rate <= item_at(rates, 1)->number))
        refuse(scene, "rate = %g Hz: expected %g to %g", scene->rate, item_at(rates, 0)->number, item_at(rates, 1)->number);
    whole_in(scene, item(scene->map, "frames"), "frames", 0.0, MANY);
    if (whole_in(scene, item(scene->map, "delay"), "delay", 0.0, quantum) % (int64_t)quantum)
        refuse(scene, "delay = %g: expected 0 or %g", number_of(scene->map, "delay"), quantum);
    for (const value *each = item(scene->map, "pulses")->first; each; each = each->next) scene->tables++;
    int has_room = scene->state_size > (int64_t)number_of(state, "values");
    if (scene->tables > (has_room ? (int64_t)number_of(state, "most_pulses") : 0) || scene->state_size % 8)
        refuse(scene, "size = %lld: it has no capacity for %lld tables of pulses", (long long)scene->state_size, (long long)scene->tables);
    scene->objects = calloc((size_t)scene->object_room + 1, sizeof *scene->objects);
    scene->freed = calloc((size_t)scene->object_room + 1, sizeof *scene->freed);
    scene->gestures = malloc(((size_t)scene->gesture_room + 1) * sizeof *scene->gestures);
    scene->inbox = malloc((size_t)(scene->ring * scene->command_size));
    if (!scene->objects || !scene->freed || !scene->gestures || !scene->inbox) refuse(scene, "no memory is left");
}

/* Expect that a scene's batches hold what the engine can take, each after those before it. */
static void expect_batches(carom *scene) {
    const value *batches = item(scene->map, "batches");
    double last = (double)scene->data_size, before = 0.0;
    int64_t count = 0;
    for (const value *each = batches->first; each; each = each->next) count++;
    scene->batches = calloc((size_t)count + 1, sizeof *scene->batches);
    if (!scene->batches) refuse(scene, "no memory is left");
    begin_memory(scene);
    expect_runs(scene, whole_in(scene, item(scene->map, "start"), "start", 0.0, last - 8.0), MAY_START);
    expect_records(scene);
    for (const value *each = batches->first; each; each = each->next) {
        batch made;
        made.at = whole_in(scene, item_at(each, 0), "a batch's sample", before, MANY);
        made.runs = whole_in(scene, item_at(each, 1), "a batch's runs", 0.0, last - 8.0);
        made.commands = whole_in(scene, item_at(each, 2), "a batch's commands", 0.0, last);
        double most = floor((last - (double)made.commands) / (double)scene->command_size);
        made.count = whole_in(scene, item_at(each, 3), "a batch's number of commands", 0.0, most);
        if (made.commands % 8) refuse(scene, "commands at %lld: expected a multiple of 8", (long long)made.commands);
        expect_runs(scene, made.runs, MAY_WRITE);
        expect_records(scene);
        for (int64_t n = 0; n < made.count; n++)
            expect_command(scene, scene->data + made.commands + n * scene->command_size);
        before = (double)made.at;
        scene->batches[scene->batch_count++] = made;
    }
}

/* Expect that what is said of objects is what a batch makes. */
static void expect_objects(carom *scene) {
    double presets = 0.0, kind = number_of(item(scene->rules, "kinds"), "NEW");
    for (const value *each = item(scene->map, "presets")->first; each; each = each->next) presets += 1.0;
    for (const value *each = item(scene->map, "objects")->first; each; each = each->next) {
        int64_t number = whole_in(scene, item(each, "batch"), "an object's batch", 0.0, (double)scene->batch_count - 1.0);
        const batch *from = &scene->batches[number];
        double last = (double)(from->commands + (from->count - 1) * scene->command_size);
        int64_t made = whole_in(scene, item(each, "made"), "an object's command", (double)from->commands, last);
        const uint8_t *command = scene->data + made;
        if ((made - from->commands) % scene->command_size || field_read(scene, command, "kind") != kind)
            refuse(scene, "%.80s: no command at %lld makes it", each->key, (long long)made);
        whole_in(scene, item(each, "preset"), "an object's preset", 0.0, presets - 1.0);
        double slot = field_read(scene, command, "slot"), serial = field_read(scene, command, "serial");
        whole_in(scene, item(each, "slot"), "an object's slot", slot, slot);
        whole_in(scene, item(each, "serial"), "an object's serial", serial, serial);
        double pitch = number_of(each, "pitch");
        if (!(pitch >= 0.0 && pitch <= 1e6)) refuse(scene, "%.80s: pitch = %g Hz: expected 0 to 1e6", each->key, pitch);
    }
}

/* The bytes of a scene, and its map. */
static void take(carom *scene, const uint8_t *baked, size_t size) {
    static const char *const strange = "expected a scene that was exported with this library";
    uint32_t length;
    uint8_t digest[SUM];
    sum found;
    if (size < HEAD || memcmp(baked, MAGIC, 8)) refuse(scene, "%s", strange);
    sum_begin(&found);
    sum_add(&found, baked, 8);
    sum_add(&found, baked + 8 + SUM, size - 8 - SUM);
    sum_end(&found, digest);
    if (memcmp(digest, baked + 8, SUM))
        refuse(scene, "it is damaged: its bytes are not those of its checksum; export the scene anew");
    memcpy(&length, baked + 8 + SUM, 4);
    if (length > size - HEAD || length % 8) refuse(scene, "its map of %lu bytes goes beyond it", (unsigned long)length);
    scene->data_size = (int64_t)(size - HEAD - length);
    scene->text = malloc((size_t)length + 1);
    scene->data = malloc((size_t)scene->data_size + 8);
    scene->rules_text = malloc(strlen(carom_engine_rules) + 1);
    if (!scene->text || !scene->data || !scene->rules_text) refuse(scene, "no memory is left");
    memcpy(scene->text, baked + HEAD, length);
    scene->text[length] = 0;
    memcpy(scene->data, baked + HEAD + length, (size_t)scene->data_size);
    scene->rules = json_read(strcpy(scene->rules_text, carom_engine_rules), strlen(carom_engine_rules));
    scene->map = json_read(scene->text, length);
    if (!scene->rules || !scene->map) refuse(scene, "its map can't be read");
    if (strcmp(text_of(scene->map, "layout"), text_of(scene->rules, "layout"))) refuse(scene, "%s", strange);
}

/* 1; 0 if a scene is refused, and it is told why. */
static int opened(carom *scene, const void *baked, size_t size) {
    if (setjmp(scene->refused)) return 0;
    take(scene, baked, size);
    find_fields(scene);
    find_places(scene);
    expect_batches(scene);
    expect_objects(scene);
    return 1;
}

carom *carom_open(const void *baked, size_t size, int live) {
    carom *scene = calloc(1, sizeof *scene);
    strcpy(unopened, scene ? "" : "no memory is left");
    if (!scene) return NULL;
    if (!opened(scene, baked, size)) {
        strcpy(unopened, scene->told);
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

static int64_t told_of(const carom *scene, const char *name) {
    int64_t place = (int64_t)number_of(item(scene->rules, "state"), name);
    return place > 0 && place <= scene->state_size - 8 ? whole_at(scene, place) : 0;
}

int carom_send(carom *scene, const char *message, double at) {
    if (!messages_perform(scene, message, at < 0.0 ? -1.0 : sample_at(scene, at))) return 0;
    int64_t lost = told_of(scene, "dropped") + told_of(scene, "linear"), before = scene->lost;
    scene->lost = lost;
    return lost > before ? CAROM_CROWDED : CAROM_SENT;
}

const char *carom_answer(const carom *scene) {
    return scene ? scene->told : unopened;
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
    return (long)(number_of(scene->map, "delay") + number_of(scene->rules, "quantum") - 1.0);
}

const char *carom_object(const carom *scene, int number) {
    return number < 0 ? NULL : item_at(item(scene->map, "objects"), number)->key;
}

double carom_pitch(const carom *scene, int number) {
    double pitch = number < 0 ? 0.0 : number_of(item_at(item(scene->map, "objects"), number), "pitch");
    return pitch > 0.0 ? 69.0 + 12.0 * log2(pitch / 440.0) : NAN;
}

void carom_report(const carom *scene, carom_state *state) {
    int64_t load = told_of(scene, "load");
    memcpy(&state->load, &load, sizeof load);
    state->frames = (long long)told_of(scene, "position");
    state->contacts = (long)told_of(scene, "active");
    state->sounding = (long)told_of(scene, "sounding");
    state->waiting = (long)told_of(scene, "queued");
    state->dropped = (long)told_of(scene, "dropped");
    int64_t loudest = told_of(scene, "loudest");
    memcpy(&state->loudest, &loudest, sizeof loudest);
    state->loudest = state->loudest > 1e-20 ? 10.0 * log10(state->loudest) - 0.691 : -200.0;
    state->linear = (long)told_of(scene, "linear");
    state->late = (long)told_of(scene, "late");
    state->refused = (long)__atomic_load_n(&scene->left_out, __ATOMIC_RELAXED);
}

void carom_close(carom *scene) {
    if (!scene) return;
    json_free(scene->map);
    json_free(scene->rules);
    free(scene->text);
    free(scene->rules_text);
    free(scene->data);
    free(scene->memory);
    free(scene->fields);
    free(scene->batches);
    free(scene->inbox);
    free(scene->objects);
    free(scene->freed);
    free(scene->touched);
    free(scene->gestures);
    free(scene);
}
