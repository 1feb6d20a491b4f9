/* A message's words, and the arguments that a map declares. */
#ifndef CAROM_WORDS_H
#define CAROM_WORDS_H

#include "inner.h"

enum { MOST_WORDS = 128, MOST_ITEMS = 512, LONGEST_MESSAGE = 4096 };

/* A word of a message: a number, a text, or a list of both. */
typedef struct {
    enum { A_NUMBER, A_TEXT, A_LIST } kind;
    const char *text; /* of a number, too */
    double number;
    int first, count; /* of a list, in `items` */
} word;

typedef struct {
    char text[LONGEST_MESSAGE];
    word words[MOST_WORDS], items[MOST_ITEMS];
    int count, item_count;
} message;

/* A value by its name: a number, or a text. */
typedef struct {
    const char *name, *text; /* text: NULL of a number */
    double number;
} named;

typedef struct {
    named entries[96];
    int count;
} table;

_Noreturn INNER void refuse(carom *scene, const char *format, ...);
_Noreturn INNER void refuse_all(carom *scene, const char *what, const char *name, const value *expected);

INNER void split(carom *scene, message *into, const char *text);
INNER double in_engine(const value *declared, double number);
INNER named checked(carom *scene, const value *declared, const word *given);
INNER void parse(carom *scene, const char *address, const value *verb, const word *words, int count, table *given,
           table *defaults);

INNER const named *entry(const table *from, const char *name);
INNER void put(carom *scene, table *into, const char *name, double number);
INNER void put_text(carom *scene, table *into, const char *name, const char *text);

/* A point of a number that may take its time. */
typedef struct {
    double value, after, over, curve;
} point;

INNER int points(carom *scene, const value *verb, const message *from, const word *words, int count, point *into, int most);

#endif
