/* A small host of CLAP plug-ins: host PLUGIN ID RATE FRAMES BLOCK OUT [STATE], events in lines of stdin.

   It opens a plug-in as hosts do, and says what it finds. It loads the state of a file, if one is given, computes frames
   in blocks of up to so many, with the events at their samples, into a file of float32, and says which notes end. It
   counts what is allocated meanwhile, and prints the state. A line is a sample, a kind, and numbers:

   on KEY VELOCITY ID CHANNEL; off, choke KEY ID CHANNEL; express EXPRESSION VALUE KEY ID CHANNEL; param ID VALUE;
   midi A B C; reset. Of -1 as the sample: a parameter, by a flush before the plug-in is activated. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clap/entry.h"
#include "clap/ext/audio-ports.h"
#include "clap/ext/latency.h"
#include "clap/ext/note-ports.h"
#include "clap/ext/params.h"
#include "clap/ext/state.h"
#include "clap/plugin-factory.h"

enum { MOST = 4096 };

typedef union {
    clap_event_header_t header;
    clap_event_note_t note;
    clap_event_note_expression_t expression;
    clap_event_param_value_t param;
    clap_event_midi_t midi;
} event;

static struct {
    long sample;
    int resets;
    event event;
} events[MOST];
static event due[MOST];
static int event_count, due_count, rescans;
static long block_begins, allocations;
static int computing;

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void __libc_free(void *);

void *malloc(size_t size) {
    allocations += computing;
    return __libc_malloc(size);
}
void *calloc(size_t count, size_t size) {
    allocations += computing;
    return __libc_calloc(count, size);
}
void *realloc(void *at, size_t size) {
    allocations += computing;
    return __libc_realloc(at, size);
}
void free(void *at) {
    allocations += computing;
    __libc_free(at);
}

static void rescan(const clap_host_t *host, clap_param_rescan_flags flags) {
    (void)host, (void)flags;
    rescans++;
}
static void clear(const clap_host_t *host, clap_id id, clap_param_clear_flags flags) {
    (void)host, (void)id, (void)flags;
}
static void ask(const clap_host_t *host) {
    (void)host;
}
static const void *extension(const clap_host_t *host, const char *id) {
    static const clap_host_params_t params = {rescan, clear, ask};
    (void)host;
    return strcmp(id, CLAP_EXT_PARAMS) ? NULL : &params;
}

static uint32_t in_size(const clap_input_events_t *list) {
    (void)list;
    return (uint32_t)due_count;
}
static const clap_event_header_t *in_get(const clap_input_events_t *list, uint32_t place) {
    (void)list;
    return &due[place].header;
}
static bool out_push(const clap_output_events_t *list, const clap_event_header_t *told) {
    const clap_event_note_t *note = (const clap_event_note_t *)told;
    (void)list;
    int was = computing;
    computing = 0;
    if (told->type == CLAP_EVENT_NOTE_END)
        printf("end %ld %d %d %d\n", block_begins + told->time, note->key, note->note_id, note->channel);
    computing = was;
    return true;
}

static int64_t write_state(const clap_ostream_t *stream, const void *bytes, uint64_t size) {
    uint64_t some = size > 7 ? 7 : size; /* less than is asked for, as streams may */
    return (int64_t)fwrite(bytes, 1, some, stream->ctx);
}
static int64_t read_state(const clap_istream_t *stream, void *bytes, uint64_t size) {
    return (int64_t)fread(bytes, 1, size > 5 ? 5 : size, stream->ctx);
}

static void read_events(void) {
    char line[256], kind[32];
    double a[6];
    while (event_count < MOST && fgets(line, sizeof line, stdin)) {
        long sample;
        memset(a, 0, sizeof a);
        if (sscanf(line, "%ld %31s %lf %lf %lf %lf %lf", &sample, kind, a, a + 1, a + 2, a + 3, a + 4) < 2) continue;
        event *e = &events[event_count].event;
        events[event_count].resets = !strcmp(kind, "reset");
        events[event_count++].sample = sample;
        e->header = (clap_event_header_t){sizeof *e, 0, CLAP_CORE_EVENT_SPACE_ID, 0xFFFF, 0};
        if (!strcmp(kind, "on")) {
            e->header.type = CLAP_EVENT_NOTE_ON;
            e->note.key = (int16_t)a[0], e->note.velocity = a[1], e->note.note_id = (int32_t)a[2];
            e->note.channel = (int16_t)a[3];
        } else if (!strcmp(kind, "off") || !strcmp(kind, "choke")) {
            e->header.type = *kind == 'o' ? CLAP_EVENT_NOTE_OFF : CLAP_EVENT_NOTE_CHOKE;
            e->note.key = (int16_t)a[0], e->note.note_id = (int32_t)a[1], e->note.channel = (int16_t)a[2];
        } else if (!strcmp(kind, "express")) {
            e->header.type = CLAP_EVENT_NOTE_EXPRESSION;
            e->expression.expression_id = (int32_t)a[0], e->expression.value = a[1];
            e->expression.key = (int16_t)a[2], e->expression.note_id = (int32_t)a[3];
            e->expression.channel = (int16_t)a[4], e->expression.port_index = 0;
        } else if (!strcmp(kind, "param")) {
            e->header.type = CLAP_EVENT_PARAM_VALUE;
            e->param.param_id = (clap_id)a[0], e->param.value = a[1];
            e->param.note_id = e->param.port_index = e->param.channel = e->param.key = -1;
        } else if (!strcmp(kind, "midi")) {
            e->header.type = CLAP_EVENT_MIDI;
            for (int n = 0; n < 3; n++) e->midi.data[n] = (uint8_t)a[n];
        }
    }
}

/* Take the events from a place on that lie before a sample: the first one behind them. */
static int take(int from, long before) {
    for (due_count = 0; from < event_count && events[from].sample < before && !events[from].resets; from++) {
        due[due_count] = events[from].event;
        due[due_count++].header.time = (uint32_t)(events[from].sample < block_begins ? 0 : events[from].sample - block_begins);
    }
    return from;
}

static void tell(const clap_plugin_factory_t *factory, const clap_plugin_t *plugin) {
    for (uint32_t n = 0; n < factory->get_plugin_count(factory); n++) {
        const clap_plugin_descriptor_t *said = factory->get_plugin_descriptor(factory, n);
        printf("plugin %s|%s|%s|%s|%s\n", said->id, said->name, said->version, said->description, said->features[0]);
    }
    const clap_plugin_params_t *params = plugin->get_extension(plugin, CLAP_EXT_PARAMS);
    const clap_plugin_audio_ports_t *audio = plugin->get_extension(plugin, CLAP_EXT_AUDIO_PORTS);
    const clap_plugin_note_ports_t *notes = plugin->get_extension(plugin, CLAP_EXT_NOTE_PORTS);
    for (uint32_t n = 0; n < params->count(plugin); n++) {
        clap_param_info_t info;
        char text[64];
        double back = -1.0;
        if (!params->get_info(plugin, n, &info)) exit(3);
        params->value_to_text(plugin, info.id, info.max_value, text, sizeof text);
        params->text_to_value(plugin, info.id, text, &back);
        printf("param %s|%g|%g|%g|%s|%g\n", info.name, info.min_value, info.max_value, info.default_value, text, back);
    }
    clap_audio_port_info_t port;
    clap_note_port_info_t keys;
    if (audio->count(plugin, true) || audio->count(plugin, false) != 1 || !audio->get(plugin, 0, false, &port)) exit(3);
    if (notes->count(plugin, true) != 1 || notes->count(plugin, false) || !notes->get(plugin, 0, true, &keys)) exit(3);
    printf("ports %u %s %u\n", port.channel_count, port.port_type, keys.supported_dialects);
}

static void compute(const clap_plugin_t *plugin, FILE *out, long frames, long block) {
    static float left[MOST], right[MOST];
    float *channels[] = {left, right};
    clap_audio_buffer_t buffer = {.data32 = channels, .channel_count = 2};
    clap_input_events_t in = {NULL, in_size, in_get};
    clap_output_events_t told = {NULL, out_push};
    int next = 0;
    clap_process_status status = CLAP_PROCESS_ERROR;
    while (next < event_count && events[next].sample < 0) next++;
    for (long n = 1; block_begins < frames; n++) {
        long size = 1 + n * 7919 % block; /* blocks of all sizes */
        if (size > frames - block_begins) size = frames - block_begins;
        if (next < event_count && events[next].resets && events[next].sample == block_begins) plugin->reset(plugin), next++;
        for (int each = next; each < event_count; each++) /* a block ends where the plug-in is reset */
            if (events[each].resets && events[each].sample < block_begins + size && events[each].sample > block_begins)
                size = events[each].sample - block_begins;
        next = take(next, block_begins + size);
        clap_process_t process = {-1, (uint32_t)size, NULL, NULL, &buffer, 0, 1, &in, &told};
        computing = 1;
        status = plugin->process(plugin, &process);
        computing = 0;
        if (status == CLAP_PROCESS_ERROR) exit(4);
        for (long f = 0; f < size; f++) fwrite(&left[f], 4, 1, out), fwrite(&right[f], 4, 1, out);
        block_begins += size;
    }
    printf("status %d\nallocations %ld\n", status, allocations);
}

int main(int count, char **words) {
    static const clap_host_t host = {CLAP_VERSION_INIT, NULL, "host", "", "", "", extension, ask, ask, ask};
    if (count < 7) return 2;
    void *file = dlopen(words[1], RTLD_LOCAL | RTLD_NOW);
    if (!file) return fprintf(stderr, "%s\n", dlerror()), 2;
    const clap_plugin_entry_t *entry = dlsym(file, "clap_entry");
    if (!entry || !entry->init(words[1]) || entry->get_factory("other")) return 3;
    const clap_plugin_factory_t *factory = entry->get_factory(CLAP_PLUGIN_FACTORY_ID);
    if (factory->create_plugin(factory, &host, "nobody")) return 3;
    const clap_plugin_t *plugin = factory->create_plugin(factory, &host, words[2]);
    if (!plugin || !plugin->init(plugin)) return 3;
    const clap_plugin_params_t *params = plugin->get_extension(plugin, CLAP_EXT_PARAMS);
    const clap_plugin_state_t *state = plugin->get_extension(plugin, CLAP_EXT_STATE);
    const clap_plugin_latency_t *latency = plugin->get_extension(plugin, CLAP_EXT_LATENCY);
    tell(factory, plugin);
    read_events();
    if (count > 7) {
        FILE *from = fopen(words[7], "rb");
        clap_istream_t stream = {from, read_state};
        printf("loaded %d", state->load(plugin, &stream));
        printf(" %d\n", rescans);
        fclose(from);
    }
    take(0, 0);
    clap_input_events_t in = {NULL, in_size, in_get};
    clap_output_events_t told = {NULL, out_push};
    params->flush(plugin, &in, &told);
    if (plugin->activate(plugin, 12345.0, 1, MOST)) return 3; /* no scene is baked for this rate */
    if (!plugin->activate(plugin, atof(words[3]), 1, MOST)) return 5;
    printf("latency %u\n", latency->get(plugin));
    if (!plugin->start_processing(plugin)) return 3;
    FILE *out = fopen(words[6], "wb");
    compute(plugin, out, atol(words[4]), atol(words[5]));
    fclose(out);
    plugin->stop_processing(plugin);
    plugin->deactivate(plugin);
    if (!plugin->activate(plugin, atof(words[3]), 1, MOST)) return 5;
    plugin->deactivate(plugin);
    clap_ostream_t stream = {stdout, write_state};
    printf("state\n");
    if (!state->save(plugin, &stream)) return 6;
    plugin->destroy(plugin);
    entry->deinit();
    return dlclose(file);
}
