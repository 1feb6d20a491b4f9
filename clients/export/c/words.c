/* Words of messages as scores have them, and arguments as a map declares them. */
#include "words.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void refuse(carom *scene, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(scene->told, sizeof scene->told, format, args);
    va_end(args);
    longjmp(scene->refused, 1);
}

void refuse_all(carom *scene, const char *what, const char *name, const value *expected) {
    size_t used = (size_t)snprintf(scene->told, sizeof scene->told, "%.80s: no such %s; expected one of ", name, what);
    const char *between = "";
    for (const value *each = expected; each && used < sizeof scene->told; each = each->next, between = ", ") {
        const char *text = each->key ? each->key : each->text;
        used += (size_t)snprintf(scene->told + used, sizeof scene->told - used, "%s%s", between, text ? text : "");
    }
    longjmp(scene->refused, 1);
}

static int is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* 1 if a word spells a number, as scores do. */
static int is_number(const char *word) {
    int digits = 0;
    if (*word == '+' || *word == '-') word++;
    for (; *word >= '0' && *word <= '9'; word++) digits++;
    if (*word == '.')
        for (word++; *word >= '0' && *word <= '9'; word++) digits++;
    if (!digits) return 0;
    if (*word == 'e' || *word == 'E') {
        word++;
        if (*word == '+' || *word == '-') word++;
        if (*word < '0' || *word > '9') return 0;
        while (*word >= '0' && *word <= '9') word++;
    }
    return !*word;
}

/* Read a word that begins at a place, and end it there: the first place behind it, and what stood there in `stopped`. */
static char *spelled(carom *scene, char *at, int listed, word *into, char *stopped) {
    char quote = *at == '"' || *at == '\'' ? *at++ : 0, *to = at, *begin = at;
    if (quote) {
        for (; *at && *at != quote; at++) {
            if (quote == '"' && *at == '\\' && at[1]) at++;
            *to++ = *at;
        }
        if (!*at++) refuse(scene, "a quote that is not closed");
    } else {
        while (*at && !is_blank(*at) && !strchr(listed ? ",[]\"'" : "\"'", *at)) at++;
        to = at;
    }
    *stopped = *at;
    if (*at && !is_blank(*at) && !(listed && (*at == ',' || *at == ']'))) refuse(scene, "a quote inside a word");
    *to = 0;
    const char *end;
    into->kind = !quote && is_number(begin) ? A_NUMBER : A_TEXT;
    into->text = begin;
    into->number = into->kind == A_NUMBER ? decimal(begin, &end) : 0.0;
    if (!isfinite(into->number)) refuse(scene, "%.40s: a number that is too large", begin);
    return at;
}

/* Read a list whose [ stands before a place: the first place behind it. */
static char *listed(carom *scene, message *into, char *at, word *list) {
    *list = (word){A_LIST, "a list", 0.0, into->item_count, 0};
    for (;;) {
        while (is_blank(*at) || *at == ',') at++;
        if (*at == ']') return at + 1;
        if (!*at) refuse(scene, "a list that is not closed");
        if (*at == '[') refuse(scene, "a list in a list: expected numbers");
        if (into->item_count == MOST_ITEMS) refuse(scene, "expected at most %d values in lists", MOST_ITEMS);
        char stopped;
        at = spelled(scene, at, 1, &into->items[into->item_count++], &stopped);
        list->count++;
        if (stopped == ']') return at + 1;
        at += stopped != 0;
    }
}

void split(carom *scene, message *into, const char *text) {
    if (strlen(text) >= LONGEST_MESSAGE) refuse(scene, "a message of %d bytes or more", LONGEST_MESSAGE);
    char *at = strcpy(into->text, text);
    into->count = into->item_count = 0;
    for (;;) {
        while (is_blank(*at)) at++;
        if (!*at || *at == '#') return;
        if (into->count == MOST_WORDS) refuse(scene, "expected at most %d words", MOST_WORDS);
        word *next = &into->words[into->count++];
        char stopped = ' ';
        if (*at == '[') {
            at = listed(scene, into, at + 1, next);
            if (*at && !is_blank(*at)) refuse(scene, "expected a blank after a list");
        } else {
            at = spelled(scene, at, 0, next, &stopped);
            at += stopped != 0;
        }
    }
}

double in_engine(const value *declared, double number) {
    const char *unit = text_of(declared, "unit");
    if (!strcmp(unit, "dB")) return pow(10.0, number / 20.0);
    return !strcmp(unit, "semitones") ? pow(2.0, number / 12.0) : number;
}

/* The number of a note's name: A4, C#3. -1: it is none. */
static double note_of(const char *name) {
    static const int steps[] = {9, 11, 0, 2, 4, 5, 7}; /* A to G */
    int letter = *name >= 'a' && *name <= 'g' ? *name - 'a' : *name >= 'A' && *name <= 'G' ? *name - 'A' : -1;
    if (letter < 0) return -1.0;
    int sharp = name[1] == '#' || name[1] == 's' ? 1 : name[1] == 'b' ? -1 : 0;
    const char *octave = name + (sharp ? 2 : 1), *digits = octave + (*octave == '-');
    size_t size = strspn(digits, "0123456789");
    if (size < 1 || size > 2 || digits[size]) return -1.0;
    return 12.0 * (atoi(octave) + 1) + steps[letter] + sharp;
}

named checked(carom *scene, const value *declared, const word *given) {
    const char *name = text_of(declared, "name"), *expected = text_of(declared, "expected");
    const value *words = item(declared, "words");
    char spelled[32];
    if (words->kind == LIST) {
        const char *text = given->text;
        if (given->kind == A_NUMBER) {
            snprintf(spelled, sizeof spelled, "%.15g", given->number);
            text = spelled;
        }
        int place = place_of(words, text);
        if (place < 0) refuse_all(scene, name, text, words->first);
        return (named){name, item_at(words, place)->text, 0.0};
    }
    if (item(declared, "low")->kind == NOTHING) {
        if (given->kind != A_TEXT || !*given->text) refuse(scene, "%s = %.80s: expected a name", name, given->text);
        return (named){name, given->text, 0.0};
    }
    double number = given->number;
    int is_note = given->kind == A_TEXT && !strcmp(name, "note") && (number = note_of(given->text)) >= 0.0;
    int is_within = number >= number_of(declared, "low") && number <= number_of(declared, "high");
    int fits = is_within || (is_true(declared, "orZero") && number == 0.0);
    if ((given->kind != A_NUMBER && !is_note) || !fits)
        refuse(scene, "%s = %.80s: expected %s", name, given->text, expected);
    if (fabs(number) < number_of(declared, "least")) number = 0.0; /* too little to tell */
    if (is_true(declared, "whole") && number != floor(number))
        refuse(scene, "%s = %.80s: expected a whole number", name, given->text);
    return (named){name, NULL, number};
}

const named *entry(const table *from, const char *name) {
    for (int n = 0; n < from->count; n++)
        if (!strcmp(from->entries[n].name, name)) return &from->entries[n];
    return NULL;
}

static void put_entry(carom *scene, table *into, named made) {
    named *found = (named *)entry(into, made.name);
    if (!found && into->count == (int)(sizeof into->entries / sizeof *into->entries)) refuse(scene, "too many keys");
    *(found ? found : &into->entries[into->count++]) = made;
}

void put(carom *scene, table *into, const char *name, double number) {
    put_entry(scene, into, (named){name, NULL, number});
}

void put_text(carom *scene, table *into, const char *name, const char *text) {
    put_entry(scene, into, (named){name, text, 0.0});
}

static const value *declared_as(const value *list, const char *name) {
    for (const value *each = list->first; each; each = each->next)
        if (!strcmp(text_of(each, "name"), name)) return each;
    return NULL;
}

static void add(carom *scene, table *given, const value *declared, const word *from) {
    if (entry(given, text_of(declared, "name")))
        refuse(scene, "%s = %.80s: given twice", text_of(declared, "name"), from->text);
    put_entry(scene, given, checked(scene, declared, from));
}

void parse(carom *scene, const char *address, const value *verb, const word *words, int count, table *given,
           table *defaults) {
    const value *keys = item(verb, "keys"), *optional = item(verb, "optional");
    given->count = defaults->count = 0;
    for (const value *each = item(verb, "required")->first; each; each = each->next) {
        if (!count--) refuse(scene, "%s is missing: %.80s", text_of(each, "name"), address);
        add(scene, given, each, words++);
    }
    for (const value *each = optional->first; each; each = each->next) {
        int is_key = count && words->kind == A_TEXT &&
                     (declared_as(keys, words->text) || declared_as(optional, words->text));
        if (count && (words->kind != A_TEXT || (count % 2 && !is_key))) {
            add(scene, given, each, words++);
            count--;
        }
    }
    for (; count > 0; count -= 2, words += 2) {
        const value *found = words->kind == A_TEXT ? declared_as(keys, words->text) : NULL;
        if (!found && words->kind == A_TEXT) found = declared_as(optional, words->text);
        if (!found) refuse(scene, "%.80s: no such key of %.80s", words->text, address);
        if (count == 1) refuse(scene, "%.80s: its value is missing", words->text);
        add(scene, given, found, words + 1);
    }
    for (int n = 0; n < 2; n++)
        for (const value *each = (n ? optional : keys)->first; each; each = each->next)
            if (item(each, "default")->kind == NUMBER)
                put(scene, defaults, text_of(each, "name"), number_of(each, "default"));
            else if (item(each, "default")->kind == TEXT)
                put_text(scene, defaults, text_of(each, "name"), text_of(each, "default"));
}

/* The words of a list, or the one word that there is. */
static const word *items_of(const message *from, const word *given, int *count) {
    *count = given->kind == A_LIST ? given->count : 1;
    return given->kind == A_LIST ? from->items + given->first : given;
}

int points(carom *scene, const value *verb, const message *from, const word *words, int count, point *into, int most) {
    const value *number = item_at(item(verb, "required"), 0), *keys = item(verb, "keys");
    const word *of_key[2] = {NULL, NULL};
    if (!count) refuse(scene, "%s is missing", text_of(number, "name"));
    for (int n = 1; n < count; n += 2) {
        const value *found = words[n].kind == A_TEXT ? declared_as(keys, words[n].text) : NULL;
        if (!found) refuse(scene, "%.80s: no such key; expected over, curve", words[n].text);
        if (n + 1 == count) refuse(scene, "%.80s: its value is missing", words[n].text);
        int key = found != keys->first;
        if (of_key[key]) refuse(scene, "%.80s = %.80s: given twice", words[n].text, words[n + 1].text);
        of_key[key] = &words[n + 1];
    }
    int size;
    const word *values = items_of(from, words, &size);
    if (!size) refuse(scene, "%s: expected a number", text_of(number, "name"));
    if (size > most) refuse(scene, "%s: expected at most %d values", text_of(number, "name"), most);
    if (size > 1 && !of_key[0])
        refuse(scene, "%s: over is missing: expected the time of each value, s", text_of(number, "name"));
    double after = 0.0, told[2] = {0.0, 0.0};
    for (int n = 0; n < size; n++) {
        for (int key = 0; key < 2; key++) {
            if (!of_key[key]) continue;
            int ones;
            const word *each = items_of(from, of_key[key], &ones);
            const value *declared = item_at(keys, key);
            if (ones != 1 && ones != size)
                refuse(scene, "%s: expected one number, or %d", text_of(declared, "name"), size);
            told[key] = checked(scene, declared, each + (ones > 1 ? n : 0)).number;
        }
        double value = in_engine(number, checked(scene, number, values + n).number);
        into[n] = (point){value, after, told[0], told[1]};
        after += told[0];
    }
    return size;
}
