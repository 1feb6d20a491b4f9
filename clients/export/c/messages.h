/* What messages are about, and the commands that they become. */
#ifndef CAROM_MESSAGES_H
#define CAROM_MESSAGES_H

#include "words.h"

#define NEUTRAL 0.5 /* the place of a macro where nothing is changed */

enum { LARGEST = 4096 };

typedef struct {
    uint8_t bytes[LARGEST];
} command;

/* What a message is about, while it is carried out. */
typedef struct {
    const char *address, *target, *action;
    const value *verb;
    const message *from;
    const word *words;
    int count;
    double time;
} call;

INNER void begin(carom *scene, command *made, const call *told, const char *kind);
INNER void set(carom *scene, command *made, const char *name, double number);
INNER void about(carom *scene, command *made, const object *of);
INNER void send_command(carom *scene, const command *made);
INNER object *object_by(const carom *scene, const char *name);
INNER running *running_by(const carom *scene, const char *id);
INNER int goes_on(const carom *scene, const char *id, const char *target, const char *action);
INNER void collect(carom *scene);
INNER int64_t start(carom *scene, const char *id, const char *target, const char *action);
INNER void make(carom *scene, const call *told);
INNER void add_object(carom *scene, object made, const char *name);
INNER void leave_place(carom *scene, const object *gone, double time);
INNER double macro_of(const carom *scene, const object *of, const value *law); /* the place of the macro that a law follows */
INNER double lawful(const value *law, double base, double place);
INNER double fitted(const value *law, double number);
INNER double stiffness_of(const carom *scene, const object *of, const value *striker, double own);
INNER double heavier(const carom *scene, const object *of);
INNER void turn(carom *scene, const call *told, object *of);
INNER void turn_like(carom *scene, object *made, double time);
INNER double send_points(carom *scene, command *made, const call *told);
INNER void gesture(carom *scene, const call *told, const object *of);

#endif
