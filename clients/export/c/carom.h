/* A scene that Carom has baked, for programs in C: no Python, no other library than libc and libm.

   Two threads may use a scene: one that sends and asks, one that computes the sound (carom_process); or one does both.
   Neither allocates nor locks. Open, load and close take no thread into account: call these alone. */
#ifndef CAROM_H
#define CAROM_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif
#ifdef __GNUC__
#ifndef CAROM_HIDDEN /* as a plug-in has the library */
#pragma GCC visibility push(default)
#endif
#endif

typedef struct carom carom;

typedef struct {
    double load;      /* share of real time that computing takes, of late */
    long long frames; /* computed so far */
    long contacts;    /* that go on */
    long sounding;    /* objects that ring */
    long waiting;     /* commands that wait for their time */
    long dropped;     /* contacts left out, as others that are heard better took all room */
    long late;        /* commands that came after their time */
    long refused;     /* commands of the score or of messages that the engine did not take: it could not, or had no room */
    double loudest;   /* momentary loudness of the loudest contact left out so far, LUFS; -200: none was */
    long linear;      /* blows that did not make a plate swell, as too many plates swelled at once */
} carom_state;

/* Open the bytes of a scene (the file scene.carom), which are copied. live: its objects are there, and nothing plays;
   0: its score plays from its first line on. Returns NULL if the bytes are no scene of this engine, are damaged or hold
   what it can't play, or no memory is left; carom_answer(NULL) then says why. */
carom *carom_open(const void *baked, size_t size, int live);

/* Begin anew, as carom_open does. */
void carom_load(carom *scene, int live);

/* Send a message, as a score's line has it without its time: "/object/bell/impact 1.0 0.3 striker wood". at: when, s of
   the scene, to the sample and finer; below 0: as soon as can be. Returns 0 if it is refused, and nothing happens. Else
   CAROM_SENT; or CAROM_CROWDED if it is sent, and since the last message that was sent `dropped` or `linear` has risen:
   the engine leaves out what is heard least when it comes to it, so that no message knows its own fate. */
enum { CAROM_SENT = 1, CAROM_CROWDED = 2 };
int carom_send(carom *scene, const char *message, double at);

/* Contacts of a game, frame by frame. Bodies are what /world/body makes in the scene's score, and objects that are made
   like these ("/object/new crate.2 crate size 1.5 material steel pan 0.2"; "/object/crate.2/free" frees them again).
   From how bodies move and touch follows what is heard: blows, slides, rolls. All is in SI units, in the axes of the
   world; the axes may be left-handed. Call these from the thread that sends. Each returns 0 if it is refused. */

/* The number of a body; -1: there is none of that name. */
int carom_body(const carom *scene, const char *name);

/* Say where a body is: its centre of mass, m; its turn, a quaternion w x y z; its velocity, m/s; its spin, rad/s. Any of
   the last three may be NULL: unturned, at rest. One that stays where it is stays without a call. */
int carom_move(carom *scene, int body, const float position[3], const float turn[4], const float velocity[3],
               const float spin[3]);

/* Say that two bodies touch in this frame, at a point, with the normal (of length 1) from a to b. impulse: of the normal
   force in the frame, N s; speed: at which they closed before they met, m/s; slip: at which they slip over each other,
   m/s. Give impulse or speed, or neither; what is not known is NAN, and follows from how the bodies move. */
int carom_touch(carom *scene, int a, int b, const float point[3], const float normal[3], float impulse, float speed,
                float slip);

/* End a frame, which was so long (s). A contact that it has not reported has ended. It is heard at once. */
int carom_frame(carom *scene, double seconds);

/* Say where the listener of bodies is, m, and which way his right ear points. */
int carom_listen(carom *scene, const float position[3], const float right[3]);

/* Let the sound take at most a share of a core, 0 to 1; 0 (as it is at first): any. While it takes more, the slides and
   blows that are heard least are left out. */
int carom_govern(carom *scene, double share);

typedef struct {
    long blows;      /* so far, and */
    long faint;      /* of them and of slides those that nobody would have heard */
    long slides;     /* slides and rolls that began */
    long left_out;   /* blows, slides and rolls for which there was no room: those that would have been heard least, and */
    double loudest;  /* the level of the loudest of these, as an estimate, dB over 20 uPa; -200: there was none */
    long crowded;    /* touches, and frames, for which there was no room */
    long bodies;     /* that there are */
} carom_contacts;

void carom_report_contacts(const carom *scene, carom_contacts *contacts);

/* The reason for which the last message was refused; else the id of the gesture that it began, "" if none lasts. Of
   NULL: the reason for which this thread's last carom_open gave none. */
const char *carom_answer(const carom *scene);

/* Compute frames of sound into `out`, float32, the channels of a frame side by side. Its bits do not depend on how many
   frames are computed at once. */
void carom_process(carom *scene, float *out, size_t frames);

int carom_channels(const carom *scene);
double carom_rate(const carom *scene);      /* Hz */
long long carom_frames(const carom *scene); /* of its score, with its tail */
long carom_delay(const carom *scene);       /* frames: a message for so many after those computed comes in time */

/* The name of an object, from 0 on in the order of the score; NULL from the last one on. */
const char *carom_object(const carom *scene, int number);

/* The note that an object plays by itself, a real number (A4 is 69); NAN where there is none. */
double carom_pitch(const carom *scene, int number);

void carom_report(const carom *scene, carom_state *state);

void carom_close(carom *scene);

#ifdef __GNUC__
#ifndef CAROM_HIDDEN
#pragma GCC visibility pop
#endif
#endif
#ifdef __cplusplus
}
#endif
#endif
