/* CLAP's host, as small as a plug-in of this file asks for. */
#include "guest.h"

#include <string.h>

#include "clap/entry.h"
#include "clap/plugin-factory.h"

extern const clap_plugin_entry_t clap_entry;

static const clap_plugin_factory_t *factory(void) { return clap_entry.get_factory(CLAP_PLUGIN_FACTORY_ID); }

uint32_t guest_count(void) { return factory()->get_plugin_count(factory()); }

const clap_plugin_descriptor_t *guest_described(uint32_t place) {
    return factory()->get_plugin_descriptor(factory(), place);
}

/* --- a plug-in's life --- */

static const void *host_extension(const clap_host_t *host, const char *id) {
    (void)host;
    (void)id;
    return NULL;
}

static void ignore(const clap_host_t *host) { (void)host; }

bool guest_open(guest *of, uint32_t place) {
    const clap_plugin_descriptor_t *described = guest_described(place);
    memset(of, 0, sizeof *of);
    of->host = (clap_host_t){
        .clap_version = CLAP_VERSION_INIT, .name = "Carom", .vendor = "Carom", .url = "", .version = described->version,
        .get_extension = host_extension, .request_restart = ignore, .request_process = ignore, .request_callback = ignore,
    };
    of->plugin = factory()->create_plugin(factory(), &of->host, described->id);
    if (!of->plugin) return false;
    of->parameters = of->plugin->get_extension(of->plugin, CLAP_EXT_PARAMS);
    of->state = of->plugin->get_extension(of->plugin, CLAP_EXT_STATE);
    of->latency = of->plugin->get_extension(of->plugin, CLAP_EXT_LATENCY);
    return of->plugin->init(of->plugin);
}

void guest_close(guest *of) {
    guest_deactivate(of);
    if (of->plugin) of->plugin->destroy(of->plugin);
    of->plugin = NULL;
}

bool guest_activate(guest *of, double rate, uint32_t most) {
    guest_deactivate(of);
    of->count = 0;
    of->is_active = of->plugin->activate(of->plugin, rate, 1, most) && of->plugin->start_processing(of->plugin);
    return of->is_active;
}

void guest_deactivate(guest *of) {
    if (!of->is_active) return;
    of->plugin->stop_processing(of->plugin);
    of->plugin->deactivate(of->plugin);
    of->is_active = false;
}

/* --- events --- */

/* Put an event behind those of its time and before. */
static void push(guest *of, const guest_event *event) {
    uint32_t place = of->count;
    if (place == MOST_EVENTS) return;
    while (place && of->events[place - 1].header.time > event->header.time) place--;
    memmove(&of->events[place + 1], &of->events[place], (of->count - place) * sizeof *event);
    of->events[place] = *event;
    of->count++;
}

static clap_event_header_t header(uint32_t size, uint32_t time, uint16_t type) {
    return (clap_event_header_t){size, time, CLAP_CORE_EVENT_SPACE_ID, type, 0};
}

void guest_set(guest *of, uint32_t time, clap_id parameter, double value) {
    guest_event event = {.parameter = {.param_id = parameter, .note_id = -1, .port_index = -1, .channel = -1, .key = -1}};
    event.parameter.header = header(sizeof event.parameter, time, CLAP_EVENT_PARAM_VALUE);
    event.parameter.value = value;
    push(of, &event);
}

void guest_note(guest *of, uint32_t time, uint16_t type, int32_t id, int16_t channel, int16_t key, double velocity) {
    guest_event event = {.note = {.note_id = id, .channel = channel, .key = key, .velocity = velocity}};
    event.note.header = header(sizeof event.note, time, type);
    push(of, &event);
}

void guest_express(guest *of, uint32_t time, int32_t expression, int32_t id, int16_t channel, int16_t key, double value) {
    guest_event event = {.expression = {.expression_id = expression, .note_id = id, .channel = channel, .key = key}};
    event.expression.header = header(sizeof event.expression, time, CLAP_EVENT_NOTE_EXPRESSION);
    event.expression.value = value;
    push(of, &event);
}

void guest_midi(guest *of, uint32_t time, const uint8_t *bytes, uint32_t size) {
    guest_event event = {.midi = {.port_index = 0}};
    if (size < 2 || size > sizeof event.midi.data || bytes[0] >= 0xF0) return;
    event.midi.header = header(sizeof event.midi, time, CLAP_EVENT_MIDI);
    memcpy(event.midi.data, bytes, size);
    push(of, &event);
}

static uint32_t event_count(const clap_input_events_t *list) { return ((const guest *)list->ctx)->count; }

static const clap_event_header_t *event_at(const clap_input_events_t *list, uint32_t place) {
    return &((const guest *)list->ctx)->events[place].header;
}

static bool take_none(const clap_output_events_t *list, const clap_event_header_t *event) {
    (void)list;
    (void)event;
    return true;
}

/* --- sound --- */

void guest_process(guest *of, float **channels, uint32_t channel_count, uint32_t frames) {
    clap_input_events_t in = {of, event_count, event_at};
    clap_output_events_t out = {NULL, take_none};
    clap_audio_buffer_t sound = {.data32 = channels, .channel_count = channel_count};
    for (uint32_t n = 0; n < of->count; n++) /* a host's slip */
        if (of->events[n].header.time >= frames) of->events[n].header.time = frames - 1;
    clap_process_t block = {
        .steady_time = -1, .frames_count = frames, .audio_outputs = &sound, .audio_outputs_count = 1,
        .in_events = &in, .out_events = &out,
    };
    of->plugin->process(of->plugin, &block);
    of->count = 0;
}

void guest_flush(guest *of) {
    clap_input_events_t in = {of, event_count, event_at};
    clap_output_events_t out = {NULL, take_none};
    of->parameters->flush(of->plugin, &in, &out);
    of->count = 0;
}
