/* A plug-in's parts: plugin.c plays, extensions.c tells the host of parameters, ports and state. */
#ifndef PLUGIN_H
#define PLUGIN_H

#include <stdatomic.h>

#include "clap/plugin.h"
#include "instrument.h"

typedef struct {
    clap_plugin_t clap;
    const clap_host_t *host;
    const instrument_object *object;
    instrument played;
    _Atomic double values[MACROS]; /* of the parameters: any thread sets them, the one that computes plays by them */
    float *frames;
    uint32_t most; /* frames that are computed at once */
    uint64_t frames_done, since_blow;
} plugin;

plugin *plugin_of(const clap_plugin_t *clap);
const void *plugin_extension(const clap_plugin_t *clap, const char *id); /* NULL: there is none of that id */
double plugin_usual(const plugin *of, int macro);
void plugin_set(plugin *of, int macro, double value);
void plugin_settle(plugin *of); /* play by the values of the parameters */
void plugin_take(plugin *of, const clap_event_header_t *event, const clap_output_events_t *out);

#endif
