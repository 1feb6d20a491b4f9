/* A scene's objects as instruments in LV2, the plug-in interface, over those of CLAP.

   Ports: MIDI; a control for each parameter; the outputs; the latency. Each object is a plug-in. Build it with the
   sources of the CLAP plug-in, and lay it beside manifest.ttl:

   cc -std=c11 -O2 -shared -fPIC -fvisibility=hidden -I. plugin.c extensions.c instrument.c guest.c \
      lv2.c libcarom.a -lm -o NAME.so */
#include <stdlib.h>
#include <string.h>

#include "guest.h"
#include "instrument.h"
#include "lv2/atom/util.h"
#include "lv2/core/lv2.h"
#include "lv2/midi/midi.h"
#include "lv2/urid/urid.h"
#include "scene.h"

enum { NOTES, FIRST_CONTROL, FIRST_OUTPUT = FIRST_CONTROL + MACROS, DELAY = FIRST_OUTPUT + CHANNELS, PORTS };

typedef struct {
    guest of;
    LV2_URID midi;
    void *ports[PORTS];
    float shown[MACROS]; /* the controls, as they were taken last */
} instance;

static LV2_Handle instantiate(
    const LV2_Descriptor *described, double rate, const char *folder, const LV2_Feature *const *features
) {
    const LV2_URID_Map *map = NULL;
    uint32_t place = 0;
    (void)folder;
    for (; features && *features; features++)
        if (!strcmp((*features)->URI, LV2_URID__map)) map = (*features)->data;
    while (place < guest_count() && strcmp(lv2_uris[place], described->URI)) place++;
    instance *made = map && place < guest_count() ? calloc(1, sizeof *made) : NULL;
    if (!made) return NULL;
    /* A host may compute any number of frames at once: the plug-in does so by parts of 4,096. */
    if (!guest_open(&made->of, place) || !guest_activate(&made->of, rate, 4096)) {
        guest_close(&made->of);
        free(made);
        return NULL;
    }
    made->midi = map->map(map->handle, LV2_MIDI__MidiEvent);
    for (int n = 0; n < MACROS; n++) {
        double value = 0.0;
        made->of.parameters->get_value(made->of.plugin, (clap_id)n, &value);
        made->shown[n] = (float)value;
    }
    return made;
}

static void connect_port(LV2_Handle handle, uint32_t port, void *data) {
    if (port < PORTS) ((instance *)handle)->ports[port] = data;
}

static void activate(LV2_Handle handle) {
    guest *of = &((instance *)handle)->of;
    of->plugin->reset(of->plugin);
}

static void run(LV2_Handle handle, uint32_t frames) {
    instance *own = handle;
    const LV2_Atom_Sequence *notes = own->ports[NOTES];
    float *outputs[CHANNELS], *latency = own->ports[DELAY];
    for (int n = 0; n < MACROS; n++) {
        const float *control = own->ports[FIRST_CONTROL + n];
        if (!control || *control == own->shown[n]) continue;
        guest_set(&own->of, 0, (clap_id)n, own->shown[n] = *control);
    }
    if (latency) *latency = (float)own->of.latency->get(own->of.plugin);
    if (!frames) {
        guest_flush(&own->of);
        return;
    }
    if (notes) LV2_ATOM_SEQUENCE_FOREACH(notes, event) {
        int64_t time = event->time.frames;
        if (event->body.type == own->midi)
            guest_midi(&own->of, time < 0 ? 0 : (uint32_t)time, LV2_ATOM_BODY_CONST(&event->body), event->body.size);
    }
    for (int n = 0; n < CHANNELS; n++) outputs[n] = own->ports[FIRST_OUTPUT + n];
    guest_process(&own->of, outputs, CHANNELS, frames);
}

static void cleanup(LV2_Handle handle) {
    guest_close(&((instance *)handle)->of);
    free(handle);
}

static const void *extension_data(const char *uri) {
    (void)uri;
    return NULL;
}

LV2_SYMBOL_EXPORT const LV2_Descriptor *lv2_descriptor(uint32_t place) {
    static LV2_Descriptor descriptors[sizeof lv2_uris / sizeof *lv2_uris];
    if (place >= guest_count()) return NULL;
    descriptors[place] = (LV2_Descriptor){
        lv2_uris[place], instantiate, connect_port, activate, run, NULL, cleanup, extension_data,
    };
    return &descriptors[place];
}
