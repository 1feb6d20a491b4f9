/* A plug-in of this file inside another format: what its host says becomes CLAP's events, in the order of their time. */
#ifndef GUEST_H
#define GUEST_H

#include "clap/events.h"
#include "clap/ext/latency.h"
#include "clap/ext/params.h"
#include "clap/ext/state.h"
#include "clap/plugin.h"

enum { MOST_EVENTS = 4096 }; /* of a block; the rest of a denser one is left out */

typedef union {
    clap_event_header_t header;
    clap_event_note_t note;
    clap_event_note_expression_t expression;
    clap_event_param_value_t parameter;
    clap_event_midi_t midi;
} guest_event;

typedef struct {
    clap_host_t host;
    const clap_plugin_t *plugin;
    const clap_plugin_params_t *parameters;
    const clap_plugin_state_t *state;
    const clap_plugin_latency_t *latency;
    bool is_active;
    uint32_t count;
    guest_event events[MOST_EVENTS];
} guest;

uint32_t guest_count(void); /* the plug-ins of this file */
const clap_plugin_descriptor_t *guest_described(uint32_t place);

bool guest_open(guest *of, uint32_t place);
void guest_close(guest *of);
bool guest_activate(guest *of, double rate, uint32_t most); /* false: the rate is none that the scene is baked for */
void guest_deactivate(guest *of);

/* Events of the next block, or, where none is computed, of now. `time` is a frame of the block. */
void guest_set(guest *of, uint32_t time, clap_id parameter, double value);
void guest_note(guest *of, uint32_t time, uint16_t type, int32_t id, int16_t channel, int16_t key, double velocity);
void guest_express(guest *of, uint32_t time, int32_t expression, int32_t id, int16_t channel, int16_t key, double value);
void guest_midi(guest *of, uint32_t time, const uint8_t *bytes, uint32_t size);

void guest_process(guest *of, float **channels, uint32_t channel_count, uint32_t frames);
void guest_flush(guest *of); /* carry out parameters alone, where nothing is computed */

#endif
