/* Objects of a scene as instruments in CLAP, the plug-in interface: the worked example of carom.h.

   Each object is a plug-in of the file's factory. Build it beside the scenes that scene.h names:

   cc -std=c11 -O2 -shared -fPIC -fvisibility=hidden plugin.c extensions.c instrument.c \
      libcarom.a -lm -o NAME.clap */
#include "plugin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clap/entry.h"
#include "clap/plugin-factory.h"

#define SCENES /* this file holds what scene.h defines */
#include "scene.h"

enum { QUIET = 4096 }; /* frames after a blow in which it may not be counted yet */

plugin *plugin_of(const clap_plugin_t *clap) {
    return clap->plugin_data;
}

/* --- events --- */

typedef struct {
    const clap_output_events_t *out;
    uint32_t time;
} listener;

static void tell_host(void *context, const body *of) {
    const listener *host = context;
    const clap_event_note_t told = {
        .header = {sizeof told, host->time, CLAP_CORE_EVENT_SPACE_ID, CLAP_EVENT_NOTE_END, 0},
        .note_id = of->id, .port_index = of->port, .channel = of->channel, .key = of->key,
    };
    if (host->out) host->out->try_push(host->out, &told.header);
}

static void express(plugin *of, const clap_event_note_expression_t *event) {
    const address key = {event->note_id, event->port_index, event->channel, event->key};
    double x = event->value;
    if (isnan(x)) return;
    switch (event->expression_id) {
    case CLAP_NOTE_EXPRESSION_TUNING: instrument_express(&of->played, key, BEND, x); break;
    case CLAP_NOTE_EXPRESSION_VOLUME: instrument_express(&of->played, key, VOLUME, 20.0 * log10(fmax(x, 1e-6))); break;
    case CLAP_NOTE_EXPRESSION_PAN: instrument_express(&of->played, key, BALANCE, 2.0 * x - 1.0); break;
    case CLAP_NOTE_EXPRESSION_PRESSURE: instrument_express(&of->played, key, PRESSURE, x); break;
    }
}

void plugin_take(plugin *of, const clap_event_header_t *event, const clap_output_events_t *out) {
    listener host = {out, event->time};
    if (event->space_id != CLAP_CORE_EVENT_SPACE_ID) return;
    of->played.frame = of->frames_done + event->time;
    if (event->type == CLAP_EVENT_PARAM_VALUE) {
        const clap_event_param_value_t *told = (const clap_event_param_value_t *)event;
        if (told->param_id < MACROS) {
            plugin_set(of, (int)told->param_id, told->value);
            plugin_settle(of);
        }
    }
    if (!of->played.scene) return;
    const clap_event_note_t *note = (const clap_event_note_t *)event;
    address key = {-1, -1, -1, -1};
    if (event->type <= CLAP_EVENT_NOTE_CHOKE) key = (address){note->note_id, note->port_index, note->channel, note->key};
    switch (event->type) {
    case CLAP_EVENT_NOTE_ON:
        instrument_strike(&of->played, key, 127.0 * note->velocity, tell_host, &host);
        of->since_blow = 0;
        break;
    case CLAP_EVENT_NOTE_OFF: instrument_release(&of->played, key); break;
    case CLAP_EVENT_NOTE_CHOKE: instrument_choke(&of->played, key, tell_host, &host); break;
    case CLAP_EVENT_NOTE_EXPRESSION: express(of, (const clap_event_note_expression_t *)event); break;
    case CLAP_EVENT_MIDI: {
        const clap_event_midi_t *midi = (const clap_event_midi_t *)event;
        instrument_midi(&of->played, (int16_t)midi->port_index, midi->data, tell_host, &host);
        of->since_blow = 0;
        break;
    }
    }
}

/* --- sound --- */

/* Compute frames, and lay each channel out by itself. */
static void compute(plugin *of, const clap_audio_buffer_t *into, uint32_t frames) {
    for (uint32_t done = 0, count; done < frames; done += count) {
        count = frames - done < of->most ? frames - done : of->most;
        carom_process(of->played.scene, of->frames, count);
        for (uint32_t c = 0; into && into->data32 && c < into->channel_count; c++)
            for (uint32_t n = 0; n < count; n++)
                into->data32[c][done + n] = c < CHANNELS ? of->frames[n * CHANNELS + c] : 0.0f;
    }
    of->frames_done += frames;
    of->since_blow += frames;
}

static clap_process_status process(const clap_plugin_t *clap, const clap_process_t *block) {
    plugin *of = plugin_of(clap);
    uint32_t events = block->in_events ? block->in_events->size(block->in_events) : 0;
    of->played.frame = of->frames_done;
    plugin_settle(of);
    for (uint32_t n = 0; n < events; n++)
        plugin_take(of, block->in_events->get(block->in_events, n), block->out_events);
    compute(of, block->audio_outputs_count ? block->audio_outputs : NULL, block->frames_count);
    carom_state state;
    carom_report(of->played.scene, &state);
    if (state.sounding || state.contacts || state.waiting || of->since_blow < QUIET) return CLAP_PROCESS_CONTINUE;
    listener host = {block->out_events, block->frames_count ? block->frames_count - 1 : 0};
    instrument_end(&of->played, tell_host, &host);
    return CLAP_PROCESS_SLEEP;
}

/* --- a plug-in's life --- */

static bool init(const clap_plugin_t *clap) {
    plugin *of = plugin_of(clap);
    for (int n = 0; n < MACROS; n++) plugin_set(of, n, plugin_usual(of, n));
    plugin_settle(of);
    return true;
}

static void deactivate(const clap_plugin_t *clap) {
    plugin *of = plugin_of(clap);
    instrument_close(&of->played);
    free(of->frames);
    of->frames = NULL;
}

static void destroy(const clap_plugin_t *clap) {
    deactivate(clap);
    free(plugin_of(clap));
}

/* True at the rates that scenes are baked for. */
static bool activate(const clap_plugin_t *clap, double rate, uint32_t least, uint32_t most) {
    plugin *of = plugin_of(clap);
    (void)least;
    for (size_t n = 0; n < sizeof scenes / sizeof *scenes; n++) {
        if (scenes[n].rate != rate) continue;
        of->most = most ? most : 1;
        of->frames_done = 0;
        of->frames = malloc(of->most * CHANNELS * sizeof *of->frames);
        if (of->frames &&
            instrument_open(&of->played, of->object, scenes[n].bytes, (size_t)(scenes[n].end - scenes[n].bytes)))
            return true;
        deactivate(clap);
    }
    return false;
}

static bool start_processing(const clap_plugin_t *clap) {
    (void)clap;
    return true;
}

static void stop_processing(const clap_plugin_t *clap) {
    (void)clap;
}

static void reset(const clap_plugin_t *clap) {
    plugin_of(clap)->frames_done = 0;
    instrument_begin(&plugin_of(clap)->played);
}

static void on_main_thread(const clap_plugin_t *clap) {
    (void)clap;
}

/* --- the factory --- */

static uint32_t count(const clap_plugin_factory_t *factory) {
    (void)factory;
    return sizeof descriptors / sizeof *descriptors;
}

static const clap_plugin_descriptor_t *described(const clap_plugin_factory_t *factory, uint32_t place) {
    return place < count(factory) ? &descriptors[place] : NULL;
}

static const clap_plugin_t *create(const clap_plugin_factory_t *factory, const clap_host_t *host, const char *id) {
    for (uint32_t n = 0; clap_version_is_compatible(host->clap_version) && n < count(factory); n++) {
        if (strcmp(descriptors[n].id, id)) continue;
        plugin *made = calloc(1, sizeof *made);
        if (!made) return NULL;
        made->host = host;
        made->object = made->played.object = &objects[n];
        made->clap = (clap_plugin_t){
            .desc = &descriptors[n], .plugin_data = made, .init = init, .destroy = destroy, .activate = activate,
            .deactivate = deactivate, .start_processing = start_processing, .stop_processing = stop_processing,
            .reset = reset, .process = process, .get_extension = plugin_extension, .on_main_thread = on_main_thread,
        };
        return &made->clap;
    }
    return NULL;
}

static bool entry_init(const char *path) {
    (void)path;
    return true;
}

static void entry_end(void) {}

static const void *factory_of(const char *id) {
    static const clap_plugin_factory_t factory = {count, described, create};
    return strcmp(id, CLAP_PLUGIN_FACTORY_ID) ? NULL : &factory;
}

CLAP_EXPORT const clap_plugin_entry_t clap_entry = {CLAP_VERSION_INIT, entry_init, entry_end, factory_of};
