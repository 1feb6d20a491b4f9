/* What a host asks a plug-in for besides sound: parameters, ports, latency, state. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clap/ext/audio-ports.h"
#include "clap/ext/latency.h"
#include "clap/ext/note-ports.h"
#include "clap/ext/params.h"
#include "clap/ext/state.h"
#include "plugin.h"
#include "scene.h"

static double highest(int macro) {
    return macro == STRIKER ? striker_count - 1 : macros[macro].high;
}

double plugin_usual(const plugin *of, int macro) {
    return macro == POSITION ? of->object->position : macros[macro].usual;
}

void plugin_set(plugin *of, int macro, double value) {
    double low = macros[macro].low, high = highest(macro);
    if (isnan(value)) return;
    if (macro == STRIKER) value = round(value);
    atomic_store(&of->values[macro], value < low ? low : value > high ? high : value);
}

void plugin_settle(plugin *of) {
    for (int n = 0; n < MACROS; n++) {
        double value = atomic_load(&of->values[n]);
        if (value != of->played.values[n]) instrument_set(&of->played, n, value);
    }
}

/* --- parameters --- */

static uint32_t count(const clap_plugin_t *clap) {
    (void)clap;
    return MACROS;
}

static bool get_info(const clap_plugin_t *clap, uint32_t place, clap_param_info_t *info) {
    if (place >= MACROS) return false;
    memset(info, 0, sizeof *info);
    info->id = place;
    info->flags = CLAP_PARAM_IS_AUTOMATABLE | (place == STRIKER ? CLAP_PARAM_IS_STEPPED : 0u);
    snprintf(info->name, sizeof info->name, "%s", macros[place].name);
    info->min_value = macros[place].low;
    info->max_value = highest((int)place);
    info->default_value = plugin_usual(plugin_of(clap), (int)place);
    return true;
}

static bool get_value(const clap_plugin_t *clap, clap_id id, double *value) {
    if (id >= MACROS) return false;
    *value = atomic_load(&plugin_of(clap)->values[id]);
    return true;
}

static bool value_to_text(const clap_plugin_t *clap, clap_id id, double value, char *text, uint32_t size) {
    (void)clap;
    if (id >= MACROS) return false;
    int place = !(value > 0.0) ? 0 : value > striker_count - 1 ? striker_count - 1 : (int)round(value);
    if (id == STRIKER)
        snprintf(text, size, "%s", strikers[place]);
    else
        snprintf(text, size, "%.2f%s", value, macros[id].unit);
    return true;
}

/* The value of a text, as a person types it. */
static bool text_to_value(const clap_plugin_t *clap, clap_id id, const char *text, double *value) {
    char *end;
    (void)clap;
    if (id >= MACROS) return false;
    for (int n = 0; id == STRIKER && n < striker_count; n++) {
        if (strcmp(strikers[n], text)) continue;
        *value = n;
        return true;
    }
    *value = strtod(text, &end);
    return end != text && id != STRIKER;
}

static void flush(const clap_plugin_t *clap, const clap_input_events_t *in, const clap_output_events_t *out) {
    for (uint32_t n = 0; n < in->size(in); n++) {
        const clap_event_header_t *event = in->get(in, n);
        if (event->type == CLAP_EVENT_PARAM_VALUE) plugin_take(plugin_of(clap), event, out);
    }
}

/* --- ports --- */

static uint32_t audio_count(const clap_plugin_t *clap, bool is_input) {
    (void)clap;
    return is_input ? 0 : 1;
}

static bool audio_get(const clap_plugin_t *clap, uint32_t place, bool is_input, clap_audio_port_info_t *info) {
    if (place >= audio_count(clap, is_input)) return false;
    memset(info, 0, sizeof *info);
    snprintf(info->name, sizeof info->name, "Output");
    info->flags = CLAP_AUDIO_PORT_IS_MAIN;
    info->channel_count = CHANNELS;
    info->port_type = CHANNELS == 2 ? CLAP_PORT_STEREO : CLAP_PORT_MONO;
    info->in_place_pair = CLAP_INVALID_ID;
    return true;
}

static uint32_t note_count(const clap_plugin_t *clap, bool is_input) {
    (void)clap;
    return is_input ? 1 : 0;
}

static bool note_get(const clap_plugin_t *clap, uint32_t place, bool is_input, clap_note_port_info_t *info) {
    if (place >= note_count(clap, is_input)) return false;
    memset(info, 0, sizeof *info);
    info->supported_dialects = CLAP_NOTE_DIALECT_CLAP | CLAP_NOTE_DIALECT_MIDI | CLAP_NOTE_DIALECT_MIDI_MPE;
    info->preferred_dialect = CLAP_NOTE_DIALECT_CLAP;
    snprintf(info->name, sizeof info->name, "Notes");
    return true;
}

static uint32_t latency(const clap_plugin_t *clap) {
    (void)clap;
    return LATENCY; /* before it is activated, too */
}

/* --- state: lines of a macro's name, = and its value as text --- */

enum { LONGEST_STATE = 4096 };
#define STATE_BEGINS "carom 1\n"

static bool save(const clap_plugin_t *clap, const clap_ostream_t *stream) {
    const plugin *of = plugin_of(clap);
    char text[LONGEST_STATE] = STATE_BEGINS;
    for (int n = 0; n < MACROS; n++) {
        double value = atomic_load(&of->values[n]);
        char *line = text + strlen(text), *number = line + strlen(macros[n].name) + 1;
        size_t room = sizeof text - (size_t)(line - text);
        if (n == STRIKER)
            snprintf(line, room, "%s=%s\n", macros[n].name, strikers[(int)value]);
        else
            snprintf(line, room, "%s=%.17g\n", macros[n].name, value);
        for (; n != STRIKER && *number; number++)
            if (*number == ',') *number = '.'; /* whatever the locale says */
    }
    for (size_t done = 0, size = strlen(text); done < size;) {
        int64_t written = stream->write(stream, text + done, size - done);
        if (written <= 0) return false;
        done += (size_t)written;
    }
    return true;
}

/* The number of a text of digits with a point, whatever the locale says. */
static double decimal(const char *text) {
    char own[64];
    snprintf(own, sizeof own, "%.1f", 0.5); /* how the locale writes it */
    char point = own[1];
    snprintf(own, sizeof own, "%s", text);
    for (char *each = own; *each; each++)
        if (*each == '.') *each = point;
    return strtod(own, NULL);
}

static void load_line(plugin *of, char *line) {
    char *value = strchr(line, '=');
    if (!value) return;
    *value++ = 0;
    for (int n = 0; n < MACROS; n++) {
        double number;
        if (strcmp(macros[n].name, line)) continue;
        if (n != STRIKER)
            plugin_set(of, n, decimal(value));
        else if (text_to_value(&of->clap, STRIKER, value, &number))
            plugin_set(of, n, number);
    }
}

static bool load(const clap_plugin_t *clap, const clap_istream_t *stream) {
    plugin *of = plugin_of(clap);
    char text[LONGEST_STATE];
    size_t size = 0;
    int64_t got;
    while (size < sizeof text - 1 && (got = stream->read(stream, text + size, sizeof text - 1 - size)) != 0) {
        if (got < 0) return false;
        size += (size_t)got;
    }
    text[size] = 0;
    if (strncmp(text, STATE_BEGINS, strlen(STATE_BEGINS))) return false;
    for (char *line = text + strlen(STATE_BEGINS), *end; (end = strchr(line, '\n')); line = end + 1) {
        *end = 0;
        load_line(of, line);
    }
    if (!of->played.scene) plugin_settle(of); /* else the thread that computes does */
    const clap_host_params_t *host = of->host->get_extension(of->host, CLAP_EXT_PARAMS);
    if (host && host->rescan) host->rescan(of->host, CLAP_PARAM_RESCAN_VALUES);
    return true;
}

const void *plugin_extension(const clap_plugin_t *clap, const char *id) {
    static const clap_plugin_params_t params = {count, get_info, get_value, value_to_text, text_to_value, flush};
    static const clap_plugin_audio_ports_t audio = {audio_count, audio_get};
    static const clap_plugin_note_ports_t notes = {note_count, note_get};
    static const clap_plugin_latency_t late = {latency};
    static const clap_plugin_state_t state = {save, load};
    const struct {
        const char *id;
        const void *extension;
    } all[] = {{CLAP_EXT_PARAMS, &params}, {CLAP_EXT_AUDIO_PORTS, &audio}, {CLAP_EXT_NOTE_PORTS, &notes},
               {CLAP_EXT_LATENCY, &late}, {CLAP_EXT_STATE, &state}};
    (void)clap;
    for (size_t n = 0; n < sizeof all / sizeof *all; n++)
        if (!strcmp(all[n].id, id)) return all[n].extension;
    return NULL;
}
