/* Contacts of a game: bodies, how they move and touch, and what the tracker makes of a frame. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "messages.h"

enum { MOST_NUMBERS = 64, CHANGED = 4, TOUCHED = 16, POSED = 14, HEARD = 6, COUNTED = 7 };

static int refused_here(carom *scene, const char *text) {
    snprintf(scene->told, sizeof scene->told, "%s", text);
    return 0;
}

/* Make a body by its row; change: octaves of size, wave speed and density, and another material or -1. */
static int64_t make_by_row(carom *scene, const value *row, const double *change, int64_t slot, int64_t serial) {
    double numbers[MOST_NUMBERS] = {0.0};
    int count = 0;
    for (const value *each = row->first; each && count < MOST_NUMBERS; each = each->next) numbers[count++] = each->number;
    if (count != (int)number_of(item(scene->rules, "touching"), "body")) return -2;
    return carom_tracker_make_body(scene->touching, numbers, change, slot, serial);
}

/* Begin the bodies of the scene's score. A row that cannot be makes none. */
void bodies_begin(carom *scene) {
    const value *bodies = item(scene->map, "bodies"), *rules = item(scene->rules, "touching");
    if (bodies->kind != MAP) return;
    scene->touching = zeros(&scene->touched, (size_t)number_of(rules, "size"));
    if (!scene->touching) return;
    carom_tracker_begin((int64_t)(intptr_t)scene->touching, scene->rate, (int64_t)number_of(rules, "rolls"));
    const value *laws = item(scene->map, "laws");
    long count = 0, number = 0;
    for (const value *each = laws->first; each; each = each->next) count++;
    long materials = (long)(sqrt((double)count) + 0.5);
    for (const value *each = laws->first; each; each = each->next, number++) {
        double told[4];
        for (int n = 0; n < 4; n++) told[n] = item_at(each, n)->number;
        carom_tracker_set_law(scene->touching, number / materials, number % materials, told);
    }
    number = 0;
    for (const value *each = item(scene->map, "slides")->first; each; each = each->next, number++) {
        double at = item_at(each, 1)->number;
        if (!(at >= 0.0 && at <= (double)(scene->data_size - scene->command_size) && at == 8.0 * floor(at / 8.0))) continue;
        carom_tracker_set_slide(scene->touching, number, item_at(each, 0)->number, scene->data + (int64_t)at);
    }
    const double change[CHANGED] = {0.0, 0.0, 0.0, -1.0};
    for (const value *each = bodies->first; each; each = each->next) {
        object *of = object_by(scene, each->key);
        int64_t made = make_by_row(scene, each, change, of ? of->slot : 0, of ? of->serial : 0);
        if (of) of->body = (int)made;
    }
}

int body_like(carom *scene, const value *row, const object *made, int64_t material) {
    const double change[CHANGED] = {made->change[0], made->change[1], made->change[2], (double)material};
    return scene->touching ? (int)make_by_row(scene, row, change, made->slot, made->serial) : -1;
}

void body_gone(carom *scene, int body) {
    if (scene->touching && body >= 0) carom_tracker_free_body(scene->touching, body);
}

int carom_body(const carom *scene, const char *name) {
    if (!name) return -1;
    const object *of = object_by(scene, name);
    if (of) return of->body >= 0 ? of->body : -1;
    int number = 0; /* of a silent one of the score, which the tracker made in its order, and nothing frees */
    for (const value *each = item(scene->map, "bodies")->first; each; each = each->next, number++)
        if (!strcmp(each->key, name)) return scene->touching && item(item(scene->map, "objects"), name)->kind != MAP ? number : -1;
    return -1;
}

static void put_floats(double *into, const float *from, int count) {
    for (int n = 0; n < count; n++) into[n] = from ? from[n] : 0.0;
}

int carom_move(carom *scene, int body, const float position[3], const float turn[4], const float velocity[3],
               const float spin[3]) {
    double told[POSED] = {body};
    put_floats(told + 1, position, 3);
    put_floats(told + 4, turn, 4);
    put_floats(told + 8, velocity, 3);
    put_floats(told + 11, spin, 3);
    if (!turn) told[4] = 1.0;
    if (scene->touching && carom_tracker_move(scene->touching, told)) return 1;
    return refused_here(scene, "carom_move: expected the number of a body, finite numbers, and a turn of length 1");
}

int carom_touch(carom *scene, int a, int b, const float point[3], const float normal[3], float impulse, float speed,
                float slip) {
    double told[TOUCHED] = {a, b};
    put_floats(told + 2, point, 3);
    put_floats(told + 5, normal, 3);
    for (int n = 8; n < TOUCHED; n++) told[n] = NAN;
    told[8] = speed;
    told[9] = slip;
    told[15] = impulse;
    if (scene->touching && carom_tracker_touch(scene->touching, told)) return 1;
    return refused_here(scene, "carom_touch: expected numbers of bodies, a normal of length 1, and impulse or speed");
}

int carom_listen(carom *scene, const float position[3], const float right[3]) {
    double told[HEARD];
    put_floats(told, position, 3);
    put_floats(told + 3, right, 3);
    if (scene->touching && carom_tracker_listen(scene->touching, told)) return 1;
    return refused_here(scene, "carom_listen: expected a scene with bodies, finite numbers, and a direction");
}

int carom_govern(carom *scene, double share) {
    if (scene->touching && carom_tracker_govern(scene->touching, share)) return 1;
    return refused_here(scene, "carom_govern: expected a scene with bodies, and a share from 0 to 1");
}

int carom_frame(carom *scene, double seconds) {
    if (!scene->touching) return refused_here(scene, "carom_frame: expected a scene with bodies: /world/body in its score");
    if (room(scene) < scene->ring / 2) { /* before the tracker takes it: else the end of a slide may get lost */
        carom_tracker_end_frame(scene->touching, 0.0, 0, 0, 0.0);
        return refused_here(scene, "carom_frame: no capacity for its commands: compute sound");
    }
    int64_t waits = whole_at(scene, (int64_t)number_of(item(scene->rules, "state"), "queued"));
    carom_state state;
    carom_report(scene, &state);
    int64_t count = carom_tracker_end_frame(scene->touching, seconds, whole_at(scene, scene->position),
                                            waits + scene->ring - room(scene), state.load);
    if (count < 0) return refused_here(scene, "carom_frame: expected 1e-6 to 1e6 seconds");
    if (count > room(scene)) return refused_here(scene, "carom_frame: no capacity for its commands: compute sound, or report fewer contacts");
    for (int64_t n = 0; n < count; n++)
        post(scene, (const uint8_t *)scene->touching + carom_tracker_command_at(scene->touching, n));
    return 1;
}

void carom_report_contacts(const carom *scene, carom_contacts *contacts) {
    double told[COUNTED] = {0.0};
    if (scene->touching) carom_tracker_report(scene->touching, told);
    double loudest = told[4] > 0.0 ? 20.0 * log10(told[4] / 20e-6) : -200.0;
    *contacts = (carom_contacts){(long)told[0], (long)told[1], (long)told[2], (long)told[3], loudest, (long)told[5], (long)told[6]};
}
