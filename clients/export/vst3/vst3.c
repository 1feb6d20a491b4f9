/* A scene's objects as instruments in VST3, the plug-in interface, over those of CLAP.

   Each object is a class of the file's factory: component, processor and controller in one. Build it with the sources of
   the CLAP plug-in, as NAME.vst3/Contents/SYSTEM/NAME.so:

   cc -std=c11 -fms-extensions -O2 -shared -fPIC -fvisibility=hidden plugin.c extensions.c \
      instrument.c guest.c vst3.c libcarom.a -lm -o NAME.so */
#include <math.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guest.h"
#include "plugin.h"
#include "scene.h"
#include "travesty/audio_processor.h"
#include "travesty/component.h"
#include "travesty/edit_controller.h"
#include "travesty/events.h"
#include "travesty/factory.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* Controllers of MIDI reach a plug-in as parameters: those that an instrument knows, of each channel, hidden. */
enum { BEND_WHEEL = 129, CHANNEL_PRESSURE = 128 }; /* among the numbers of controllers */
static const uint8_t controllers[] = {BEND_WHEEL, CHANNEL_PRESSURE, 64, 74, 123};
enum { CONTROLLERS = sizeof controllers, FIRST_HIDDEN = 1024, HIDDEN = CHANNELS_OF_MIDI * CONTROLLERS };

/* The interface of expressions of notes, which the headers lack. */
static const v3_tuid expressions_iid = V3_ID(0xB7F8F859, 0x41234872, 0x91169581, 0x4F3721A3);

struct expression_info {
    uint32_t type;
    v3_str_128 title, short_title, units;
    int32_t unit;
    double usual, low, high;
    int32_t steps;
    v3_param_id parameter;
    int32_t flags;
};

struct expressions {
    struct v3_funknown;
    int32_t (V3_API *count)(void *self, int32_t bus, int16_t channel);
    v3_result (V3_API *info)(void *self, int32_t bus, int16_t channel, int32_t place, struct expression_info *info);
    v3_result (V3_API *text)(void *self, int32_t bus, int16_t channel, uint32_t type, double value, v3_str_128 text);
    v3_result (V3_API *value)(void *self, int32_t bus, int16_t channel, uint32_t type, const int16_t *text, double *value);
};

/* The expressions of VST3 that CLAP has too. */
enum { VOLUME_TYPE, PAN_TYPE, TUNING_TYPE, EXPRESSION_TYPES };
enum { IS_BIPOLAR = 1, TUNING_RANGE = 240 }; /* semitones, from -120 to 120 */

typedef struct {
    const struct v3_component *component;
    const struct v3_audio_processor *processor;
    const struct v3_edit_controller *controller;
    const struct v3_midi_mapping *mapping;
    const struct expressions *expressions;
    _Atomic uint32_t references;
    double rate;
    int32_t most;
    guest of;
} instance;

#define OWNER(self, face) ((instance *)((char *)(self) - offsetof(instance, face)))

/* --- texts of UTF-16 --- */

static void widen(int16_t *into, size_t room, const char *text) {
    const uint8_t *from = (const uint8_t *)text;
    size_t size = 0;
    while (*from && size + 2 < room) {
        int more = *from < 0xC0 ? 0 : *from < 0xE0 ? 1 : *from < 0xF0 ? 2 : 3;
        uint32_t letter = more ? *from & (0x3Fu >> more) : *from;
        for (from++; more && (*from & 0xC0) == 0x80; more--, from++) letter = letter << 6 | (*from & 0x3Fu);
        if (letter > 0xFFFF) {
            into[size++] = (int16_t)(0xD7C0 + (letter >> 10));
            letter = 0xDC00 | (letter & 0x3FF);
        }
        into[size++] = (int16_t)letter;
    }
    into[size] = 0;
}

static void narrow(char *into, size_t room, const int16_t *text) { /* of ASCII, as all texts of parameters are */
    size_t size = 0;
    for (; text[size] && size + 1 < room; size++) into[size] = (char)(text[size] & 0x7F);
    into[size] = 0;
}

/* --- parameters --- */

static bool is_hidden(v3_param_id id) { return id >= FIRST_HIDDEN && id < FIRST_HIDDEN + HIDDEN; }

static bool described(const instance *own, v3_param_id id, clap_param_info_t *info) {
    return own->of.parameters->get_info(own->of.plugin, id, info);
}

static double share_of(const clap_param_info_t *info, double value) {
    double range = info->max_value - info->min_value;
    return range > 0.0 ? fmin(fmax((value - info->min_value) / range, 0.0), 1.0) : 0.0;
}

/* The value of a share; the usual one where the share is its own as a host's float32 has it. */
static double plain_of(const clap_param_info_t *info, double share) {
    if ((float)share == (float)share_of(info, info->default_value)) return info->default_value;
    return info->min_value + fmin(fmax(share, 0.0), 1.0) * (info->max_value - info->min_value);
}

/* A value between 0 and 1 of a controller of MIDI, as a message. */
static void control(guest *of, uint32_t time, v3_param_id id, double share) {
    uint8_t channel = (uint8_t)((id - FIRST_HIDDEN) / CONTROLLERS), number = controllers[(id - FIRST_HIDDEN) % CONTROLLERS];
    int bend = (int)lround(fmin(fmax(share, 0.0), 1.0) * 16383.0), value = (int)lround(fmin(fmax(share, 0.0), 1.0) * 127.0);
    const uint8_t message[] = {
        (uint8_t)((number == BEND_WHEEL ? 0xE0 : number == CHANNEL_PRESSURE ? 0xD0 : 0xB0) | channel),
        (uint8_t)(number == BEND_WHEEL ? bend & 127 : number == CHANNEL_PRESSURE ? value : number),
        (uint8_t)(number == BEND_WHEEL ? bend >> 7 : number == CHANNEL_PRESSURE ? 0 : value),
    };
    guest_midi(of, time, message, sizeof message);
}

/* --- state: CLAP's --- */

static int64_t read_some(const clap_istream_t *stream, void *into, uint64_t size) {
    struct v3_bstream **from = stream->ctx;
    int32_t got = 0, asked = size < 65536 ? (int32_t)size : 65536;
    return (*from)->read(from, into, asked, &got) == V3_OK ? got : 0;
}

static int64_t write_some(const clap_ostream_t *stream, const void *from, uint64_t size) {
    struct v3_bstream **into = stream->ctx;
    int32_t put = 0, asked = size < 65536 ? (int32_t)size : 65536;
    return (*into)->write(into, (void *)(uintptr_t)from, asked, &put) == V3_OK ? put : -1;
}

static v3_result load(instance *own, struct v3_bstream **from) {
    const clap_istream_t stream = {from, read_some};
    return from && own->of.state->load(own->of.plugin, &stream) ? V3_OK : V3_FALSE;
}

static v3_result save(instance *own, struct v3_bstream **into) {
    const clap_ostream_t stream = {into, write_some};
    return into && own->of.state->save(own->of.plugin, &stream) ? V3_OK : V3_FALSE;
}

/* --- what all faces share --- */

static v3_result find(instance *own, const v3_tuid iid, void **found) {
    const struct {
        const uint8_t *iid;
        void *face;
    } faces[] = {
        {v3_funknown_iid, &own->component},          {v3_plugin_base_iid, &own->component},
        {v3_component_iid, &own->component},         {v3_audio_processor_iid, &own->processor},
        {v3_edit_controller_iid, &own->controller},  {v3_midi_mapping_iid, &own->mapping},
        {expressions_iid, &own->expressions},
    };
    *found = NULL;
    for (size_t n = 0; n < sizeof faces / sizeof *faces; n++) {
        if (!v3_tuid_match(faces[n].iid, iid)) continue;
        *found = faces[n].face;
        atomic_fetch_add(&own->references, 1);
        return V3_OK;
    }
    return V3_NO_INTERFACE;
}

static uint32_t release(instance *own) {
    uint32_t left = atomic_fetch_sub(&own->references, 1) - 1;
    if (left) return left;
    guest_close(&own->of);
    free(own);
    return 0;
}

#define SHARED(face) \
    static v3_result V3_API query_##face(void *self, const v3_tuid iid, void **found) { return find(OWNER(self, face), iid, found); } \
    static uint32_t V3_API ref_##face(void *self) { return atomic_fetch_add(&OWNER(self, face)->references, 1) + 1; } \
    static uint32_t V3_API unref_##face(void *self) { return release(OWNER(self, face)); }

SHARED(component)
SHARED(processor)
SHARED(controller)
SHARED(mapping)
SHARED(expressions)

static v3_result V3_API initialize(void *self, struct v3_funknown **context) {
    (void)self;
    (void)context;
    return V3_OK;
}

static v3_result V3_API terminate(void *self) {
    (void)self;
    return V3_OK;
}

/* --- the component --- */

static v3_result V3_API controller_class(void *self, v3_tuid id) { /* none: it is this one */
    (void)self;
    (void)id;
    return V3_NOT_IMPLEMENTED;
}

static v3_result V3_API set_io_mode(void *self, int32_t mode) {
    (void)self;
    (void)mode;
    return V3_NOT_IMPLEMENTED;
}

static bool has_bus(int32_t media, int32_t direction, int32_t place) {
    return place == 0 && ((media == V3_AUDIO && direction == V3_OUTPUT) || (media == V3_EVENT && direction == V3_INPUT));
}

static int32_t V3_API bus_count(void *self, int32_t media, int32_t direction) {
    (void)self;
    return has_bus(media, direction, 0);
}

static v3_result V3_API bus_info(void *self, int32_t media, int32_t direction, int32_t place, struct v3_bus_info *info) {
    (void)self;
    if (!has_bus(media, direction, place)) return V3_INVALID_ARG;
    memset(info, 0, sizeof *info);
    info->media_type = media;
    info->direction = direction;
    info->channel_count = media == V3_AUDIO ? (int)CHANNELS : (int)CHANNELS_OF_MIDI;
    info->bus_type = V3_MAIN;
    info->flags = V3_DEFAULT_ACTIVE;
    widen(info->bus_name, 128, media == V3_AUDIO ? "Output" : "Notes");
    return V3_OK;
}

static v3_result V3_API routing_info(void *self, struct v3_routing_info *in, struct v3_routing_info *out) {
    (void)self;
    (void)in;
    (void)out;
    return V3_NOT_IMPLEMENTED;
}

static v3_result V3_API activate_bus(void *self, int32_t media, int32_t direction, int32_t place, v3_bool state) {
    (void)self;
    (void)state;
    return has_bus(media, direction, place) ? V3_OK : V3_INVALID_ARG;
}

static v3_result V3_API set_active(void *self, v3_bool state) {
    instance *own = OWNER(self, component);
    if (!state) {
        guest_deactivate(&own->of);
        return V3_OK;
    }
    return guest_activate(&own->of, own->rate, (uint32_t)own->most) ? V3_OK : V3_FALSE;
}

static v3_result V3_API set_component_state(void *self, struct v3_bstream **from) { return load(OWNER(self, component), from); }
static v3_result V3_API get_component_state(void *self, struct v3_bstream **into) { return save(OWNER(self, component), into); }

/* --- the processor --- */

static const v3_speaker_arrangement speakers = CHANNELS == 2 ? V3_SPEAKER_L | V3_SPEAKER_R : V3_SPEAKER_M;

static v3_result V3_API set_arrangements(
    void *self, v3_speaker_arrangement *inputs, int32_t input_count, v3_speaker_arrangement *outputs, int32_t output_count
) {
    (void)self;
    (void)inputs;
    return input_count == 0 && output_count == 1 && outputs[0] == speakers ? V3_OK : V3_FALSE;
}

static v3_result V3_API get_arrangement(void *self, int32_t direction, int32_t place, v3_speaker_arrangement *found) {
    (void)self;
    if (!has_bus(V3_AUDIO, direction, place)) return V3_INVALID_ARG;
    *found = speakers;
    return V3_OK;
}

static v3_result V3_API can_process(void *self, int32_t size) {
    (void)self;
    return size == V3_SAMPLE_32 ? V3_OK : V3_FALSE;
}

static uint32_t V3_API latency(void *self) {
    const guest *of = &OWNER(self, processor)->of;
    return of->latency->get(of->plugin);
}

static v3_result V3_API setup(void *self, struct v3_process_setup *asked) {
    instance *own = OWNER(self, processor);
    if (asked->symbolic_sample_size != V3_SAMPLE_32 || asked->max_block_size < 1) return V3_INVALID_ARG;
    own->rate = asked->sample_rate;
    own->most = asked->max_block_size;
    return V3_OK;
}

static v3_result V3_API set_processing(void *self, v3_bool state) {
    instance *own = OWNER(self, processor);
    if (state && own->of.is_active) own->of.plugin->reset(own->of.plugin);
    return V3_OK;
}

/* Take each point of each parameter. */
static void take_changes(instance *own, struct v3_param_changes **changes) {
    for (int32_t n = 0; changes && n < (*changes)->get_param_count(changes); n++) {
        struct v3_param_value_queue **queue = (*changes)->get_param_data(changes, n);
        v3_param_id id = queue ? (*queue)->get_param_id(queue) : UINT32_MAX;
        clap_param_info_t info;
        bool is_own = id < MACROS && described(own, id, &info);
        for (int32_t k = 0; queue && k < (*queue)->get_point_count(queue); k++) {
            int32_t time;
            double share;
            if ((*queue)->get_point(queue, k, &time, &share) != V3_OK || time < 0) continue;
            if (is_own) guest_set(&own->of, (uint32_t)time, id, plain_of(&info, share));
            if (is_hidden(id)) control(&own->of, (uint32_t)time, id, share);
        }
    }
}

static void express(guest *of, uint32_t time, int32_t id, uint32_t type, double x) {
    if (type == VOLUME_TYPE) guest_express(of, time, CLAP_NOTE_EXPRESSION_VOLUME, id, -1, -1, 4.0 * x);
    if (type == PAN_TYPE) guest_express(of, time, CLAP_NOTE_EXPRESSION_PAN, id, -1, -1, x);
    if (type == TUNING_TYPE) guest_express(of, time, CLAP_NOTE_EXPRESSION_TUNING, id, -1, -1, TUNING_RANGE * (x - 0.5));
}

/* A velocity of MIDI as a host's float32 has it: the bits of other formats, where it is one of theirs. */
static double velocity_of(float share) {
    double value = 127.0 * share, near = round(value);
    return (fabs(value - near) < 1e-4 ? near : value) / 127.0;
}

static void take_event(guest *of, const struct v3_event *event) {
    uint32_t time = event->sample_offset < 0 ? 0 : (uint32_t)event->sample_offset;
    const struct v3_event_note_on *on = &event->note_on;
    const struct v3_event_note_off *off = &event->note_off;
    const struct v3_event_poly_pressure *press = &event->poly_pressure;
    switch (event->type) {
    case V3_EVENT_NOTE_ON:
        guest_note(of, time, CLAP_EVENT_NOTE_ON, on->note_id, on->channel, on->pitch, velocity_of(on->velocity));
        if (on->tuning != 0.0f) /* cents */
            guest_express(of, time, CLAP_NOTE_EXPRESSION_TUNING, on->note_id, on->channel, on->pitch, on->tuning / 100.0);
        break;
    case V3_EVENT_NOTE_OFF:
        guest_note(of, time, CLAP_EVENT_NOTE_OFF, off->note_id, off->channel, off->pitch, off->velocity);
        break;
    case V3_EVENT_POLY_PRESSURE:
        guest_express(
            of, time, CLAP_NOTE_EXPRESSION_PRESSURE, press->note_id, press->channel, press->pitch, press->pressure);
        break;
    case V3_EVENT_NOTE_EXP_VALUE:
        express(of, time, event->note_exp_value.note_id, event->note_exp_value.type_id, event->note_exp_value.value);
        break;
    }
}

static v3_result V3_API process(void *self, struct v3_process_data *block) {
    instance *own = OWNER(self, processor);
    if (!own->of.is_active) return V3_NOT_INITIALIZED;
    take_changes(own, block->input_params);
    struct v3_event_list **list = block->input_events;
    for (uint32_t n = 0; list && n < (*list)->get_event_count(list); n++) {
        struct v3_event event;
        if ((*list)->get_event(list, (int32_t)n, &event) == V3_OK) take_event(&own->of, &event);
    }
    if (block->nframes < 1) {
        guest_flush(&own->of);
        return V3_OK;
    }
    struct v3_audio_bus_buffers *output = block->num_output_buses ? &block->outputs[0] : NULL;
    bool has_sound = output && output->channel_buffers_32;
    guest_process(
        &own->of, has_sound ? output->channel_buffers_32 : NULL, has_sound ? (uint32_t)output->num_channels : 0,
        (uint32_t)block->nframes);
    if (output) output->channel_silence_bitset = 0;
    return V3_OK;
}

static uint32_t V3_API tail(void *self) {
    (void)self;
    return UINT32_MAX; /* without end: what rings, rings */
}

/* --- the controller --- */

static v3_result V3_API take_component_state(void *self, struct v3_bstream **from) { return load(OWNER(self, controller), from); }

static v3_result V3_API own_state(void *self, struct v3_bstream **stream) { /* it has none besides the component's */
    (void)self;
    (void)stream;
    return V3_OK;
}

static int32_t V3_API parameter_count(void *self) {
    (void)self;
    return MACROS + HIDDEN;
}

static v3_result V3_API parameter_info(void *self, int32_t place, struct v3_param_info *told) {
    clap_param_info_t info;
    memset(told, 0, sizeof *told);
    if (place >= MACROS && place < MACROS + HIDDEN) {
        char title[64];
        int hidden = place - MACROS, number = controllers[hidden % CONTROLLERS];
        snprintf(title, sizeof title, "Channel %d, controller %d", hidden / CONTROLLERS + 1, number);
        if (number == BEND_WHEEL) snprintf(title, sizeof title, "Channel %d, bend", hidden / CONTROLLERS + 1);
        if (number == CHANNEL_PRESSURE) snprintf(title, sizeof title, "Channel %d, pressure", hidden / CONTROLLERS + 1);
        told->param_id = (v3_param_id)(FIRST_HIDDEN + hidden);
        told->default_normalised_value = number == BEND_WHEEL ? 0.5 : 0.0;
        told->flags = V3_PARAM_IS_HIDDEN;
        widen(told->title, 128, title);
        widen(told->short_title, 128, title);
        return V3_OK;
    }
    if (place < 0 || !described(OWNER(self, controller), (v3_param_id)place, &info)) return V3_INVALID_ARG;
    told->param_id = info.id;
    widen(told->title, 128, info.name);
    widen(told->short_title, 128, info.name);
    widen(told->units, 128, macros[place].unit + (*macros[place].unit == ' '));
    told->default_normalised_value = share_of(&info, info.default_value);
    told->flags = V3_PARAM_CAN_AUTOMATE;
    if (info.flags & CLAP_PARAM_IS_STEPPED) {
        told->step_count = (int32_t)(info.max_value - info.min_value);
        told->flags |= V3_PARAM_IS_LIST;
    }
    return V3_OK;
}

static double V3_API to_plain(void *self, v3_param_id id, double share) {
    clap_param_info_t info;
    return described(OWNER(self, controller), id, &info) ? plain_of(&info, share) : share;
}

static double V3_API to_share(void *self, v3_param_id id, double value) {
    clap_param_info_t info;
    return described(OWNER(self, controller), id, &info) ? share_of(&info, value) : value;
}

static v3_result V3_API text_of(void *self, v3_param_id id, double share, v3_str_128 text) {
    const guest *of = &OWNER(self, controller)->of;
    char own[128];
    if (is_hidden(id))
        snprintf(own, sizeof own, "%.2f", share);
    else if (!of->parameters->value_to_text(of->plugin, id, to_plain(self, id, share), own, sizeof own))
        return V3_INVALID_ARG;
    widen(text, 128, own);
    return V3_OK;
}

static v3_result V3_API value_of(void *self, v3_param_id id, int16_t *text, double *share) {
    const guest *of = &OWNER(self, controller)->of;
    char own[128];
    double value;
    narrow(own, sizeof own, text);
    if (!of->parameters->text_to_value(of->plugin, id, own, &value)) return V3_FALSE;
    *share = to_share(self, id, value);
    return V3_OK;
}

static double V3_API get_parameter(void *self, v3_param_id id) {
    const guest *of = &OWNER(self, controller)->of;
    double value = 0.0;
    if (!of->parameters->get_value(of->plugin, id, &value)) return 0.0;
    return to_share(self, id, value);
}

static v3_result V3_API set_parameter(void *self, v3_param_id id, double share) {
    instance *own = OWNER(self, controller);
    if (is_hidden(id)) return V3_OK;
    if (id >= MACROS || isnan(share)) return V3_INVALID_ARG;
    plugin_set(plugin_of(own->of.plugin), (int)id, to_plain(self, id, share));
    return V3_OK;
}

static v3_result V3_API set_handler(void *self, struct v3_component_handler **handler) {
    (void)self;
    (void)handler;
    return V3_OK;
}

static struct v3_plugin_view **V3_API create_view(void *self, const char *name) {
    (void)self;
    (void)name;
    return NULL;
}

static v3_result V3_API assignment(void *self, int32_t bus, int16_t channel, int16_t number, v3_param_id *id) {
    (void)self;
    for (int n = 0; n < CONTROLLERS && bus == 0 && channel >= 0 && channel < CHANNELS_OF_MIDI; n++) {
        if (controllers[n] != number) continue;
        *id = (v3_param_id)(FIRST_HIDDEN + channel * CONTROLLERS + n);
        return V3_OK;
    }
    return V3_FALSE;
}

/* --- expressions of notes --- */

static int32_t V3_API expression_count(void *self, int32_t bus, int16_t channel) {
    (void)self;
    (void)channel;
    return bus == 0 ? EXPRESSION_TYPES : 0;
}

static v3_result V3_API expression_info(
    void *self, int32_t bus, int16_t channel, int32_t place, struct expression_info *info
) {
    static const char *const titles[] = {"Volume", "Pan", "Tuning"}, *const units[] = {"dB", "", "semitones"};
    (void)self;
    (void)channel;
    if (bus != 0 || place < 0 || place >= EXPRESSION_TYPES) return V3_INVALID_ARG;
    memset(info, 0, sizeof *info);
    info->type = (uint32_t)place;
    widen(info->title, 128, titles[place]);
    widen(info->short_title, 128, titles[place]);
    widen(info->units, 128, units[place]);
    info->unit = -1;
    info->usual = place == VOLUME_TYPE ? 0.25 : 0.5;
    info->high = 1.0;
    info->flags = place == VOLUME_TYPE ? 0 : IS_BIPOLAR;
    return V3_OK;
}

static v3_result V3_API expression_text(
    void *self, int32_t bus, int16_t channel, uint32_t type, double value, v3_str_128 text
) {
    char own[64];
    (void)self;
    (void)channel;
    if (bus != 0 || type >= EXPRESSION_TYPES) return V3_INVALID_ARG;
    if (type == VOLUME_TYPE) snprintf(own, sizeof own, "%.1f dB", 20.0 * log10(fmax(4.0 * value, 1e-6)));
    if (type == PAN_TYPE) snprintf(own, sizeof own, "%.2f", 2.0 * value - 1.0);
    if (type == TUNING_TYPE) snprintf(own, sizeof own, "%.2f semitones", TUNING_RANGE * (value - 0.5));
    widen(text, 128, own);
    return V3_OK;
}

static v3_result V3_API expression_value(
    void *self, int32_t bus, int16_t channel, uint32_t type, const int16_t *text, double *value
) {
    char own[64], *end;
    (void)self;
    (void)channel;
    narrow(own, sizeof own, text);
    double number = strtod(own, &end);
    if (bus != 0 || type >= EXPRESSION_TYPES || end == own) return V3_FALSE;
    double share = type == VOLUME_TYPE ? pow(10.0, number / 20.0) / 4.0 : type == PAN_TYPE ? (number + 1.0) / 2.0 : number / TUNING_RANGE + 0.5;
    *value = fmin(fmax(share, 0.0), 1.0);
    return V3_OK;
}

/* --- the factory --- */

static const struct v3_component component = {
    .query_interface = query_component, .ref = ref_component, .unref = unref_component, .initialize = initialize,
    .terminate = terminate, .get_controller_class_id = controller_class, .set_io_mode = set_io_mode,
    .get_bus_count = bus_count, .get_bus_info = bus_info, .get_routing_info = routing_info, .activate_bus = activate_bus,
    .set_active = set_active, .set_state = set_component_state, .get_state = get_component_state,
};

static const struct v3_audio_processor processor = {
    .query_interface = query_processor, .ref = ref_processor, .unref = unref_processor,
    .set_bus_arrangements = set_arrangements, .get_bus_arrangement = get_arrangement,
    .can_process_sample_size = can_process, .get_latency_samples = latency, .setup_processing = setup,
    .set_processing = set_processing, .process = process, .get_tail_samples = tail,
};

static const struct v3_edit_controller controller = {
    .query_interface = query_controller, .ref = ref_controller, .unref = unref_controller, .initialize = initialize,
    .terminate = terminate, .set_component_state = take_component_state, .set_state = own_state, .get_state = own_state,
    .get_parameter_count = parameter_count, .get_parameter_info = parameter_info,
    .get_parameter_string_for_value = text_of, .get_parameter_value_for_string = value_of,
    .normalised_parameter_to_plain = to_plain, .plain_parameter_to_normalised = to_share,
    .get_parameter_normalised = get_parameter, .set_parameter_normalised = set_parameter,
    .set_component_handler = set_handler, .create_view = create_view,
};

static const struct v3_midi_mapping mapping = {
    .query_interface = query_mapping, .ref = ref_mapping, .unref = unref_mapping,
    .get_midi_controller_assignment = assignment,
};

static const struct expressions expressions = {
    .query_interface = query_expressions, .ref = ref_expressions, .unref = unref_expressions, .count = expression_count,
    .info = expression_info, .text = expression_text, .value = expression_value,
};

static v3_result V3_API create(void *self, const v3_tuid id, const v3_tuid iid, void **made) {
    uint32_t place = 0;
    (void)self;
    *made = NULL;
    while (place < guest_count() && !v3_tuid_match(vst3_ids[place], id)) place++;
    instance *own = place < guest_count() ? calloc(1, sizeof *own) : NULL;
    if (!own) return place < guest_count() ? V3_NOMEM : V3_INVALID_ARG;
    own->component = &component;
    own->processor = &processor;
    own->controller = &controller;
    own->mapping = &mapping;
    own->expressions = &expressions;
    own->references = 1;
    own->rate = 48000.0;
    own->most = 4096;
    v3_result found = guest_open(&own->of, place) ? find(own, iid, made) : V3_INTERNAL_ERR;
    release(own);
    return found;
}

static v3_result V3_API query_factory(void *self, const v3_tuid iid, void **found) {
    bool is_known = v3_tuid_match(iid, v3_funknown_iid) || v3_tuid_match(iid, v3_plugin_factory_iid) ||
                    v3_tuid_match(iid, v3_plugin_factory_2_iid) || v3_tuid_match(iid, v3_plugin_factory_3_iid);
    *found = is_known ? self : NULL;
    return is_known ? V3_OK : V3_NO_INTERFACE;
}

static uint32_t V3_API count_factory(void *self) { /* it lives as long as the file is loaded */
    (void)self;
    return 1;
}

static v3_result V3_API factory_info(void *self, struct v3_factory_info *info) {
    (void)self;
    memset(info, 0, sizeof *info);
    snprintf(info->vendor, sizeof info->vendor, "Carom");
    info->flags = 0x10; /* texts are Unicode */
    return V3_OK;
}

static int32_t V3_API class_count(void *self) {
    (void)self;
    return (int32_t)guest_count();
}

static const char CATEGORY[] = "Audio Module Class", KINDS[] = "Instrument|Synth", SDK[] = "VST 3.7.4";

static v3_result V3_API class_2(void *self, int32_t place, struct v3_class_info_2 *info) {
    (void)self;
    if (place < 0 || place >= (int32_t)guest_count()) return V3_INVALID_ARG;
    const clap_plugin_descriptor_t *told = guest_described((uint32_t)place);
    memset(info, 0, sizeof *info);
    memcpy(info->class_id, vst3_ids[place], sizeof info->class_id);
    info->cardinality = 0x7FFFFFFF;
    snprintf(info->category, sizeof info->category, "%s", CATEGORY);
    snprintf(info->name, sizeof info->name, "%s", told->name);
    snprintf(info->sub_categories, sizeof info->sub_categories, "%s", KINDS);
    snprintf(info->vendor, sizeof info->vendor, "%s", told->vendor);
    snprintf(info->version, sizeof info->version, "%s", told->version);
    snprintf(info->sdk_version, sizeof info->sdk_version, "%s", SDK);
    return V3_OK;
}

static v3_result V3_API class_1(void *self, int32_t place, struct v3_class_info *info) {
    struct v3_class_info_2 more;
    v3_result found = class_2(self, place, &more);
    if (found != V3_OK) return found;
    memcpy(info, &more, sizeof *info); /* it begins as that does */
    return V3_OK;
}

static v3_result V3_API class_3(void *self, int32_t place, struct v3_class_info_3 *info) {
    struct v3_class_info_2 narrow;
    v3_result found = class_2(self, place, &narrow);
    if (found != V3_OK) return found;
    memset(info, 0, sizeof *info);
    memcpy(info->class_id, narrow.class_id, sizeof info->class_id);
    info->cardinality = narrow.cardinality;
    memcpy(info->category, narrow.category, sizeof info->category);
    memcpy(info->sub_categories, narrow.sub_categories, sizeof info->sub_categories);
    widen(info->name, 64, narrow.name);
    widen(info->vendor, 64, narrow.vendor);
    widen(info->version, 64, narrow.version);
    widen(info->sdk_version, 64, narrow.sdk_version);
    return V3_OK;
}

static v3_result V3_API take_context(void *self, struct v3_funknown **host) {
    (void)self;
    (void)host;
    return V3_OK;
}

EXPORT const void *GetPluginFactory(void) {
    static const struct v3_plugin_factory_3 functions = {
        .query_interface = query_factory, .ref = count_factory, .unref = count_factory, .get_factory_info = factory_info,
        .num_classes = class_count, .get_class_info = class_1, .create_instance = create, .get_class_info_2 = class_2,
        .get_class_info_utf16 = class_3, .set_host_context = take_context,
    };
    static const struct v3_plugin_factory_3 *const factory = &functions;
    return &factory;
}

/* Hosts of each system call two functions of their own before and after all others. */
#if defined _WIN32
EXPORT bool InitDll(void) { return true; }

EXPORT bool ExitDll(void) { return true; }
#elif defined __APPLE__
EXPORT bool bundleEntry(void *library) { return library; }

EXPORT bool bundleExit(void) { return true; }
#else
EXPORT bool ModuleEntry(void *library) { return library; }

EXPORT bool ModuleExit(void) { return true; }
#endif
