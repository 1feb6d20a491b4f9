/* The whole library. */
#include "json.c"
#include "words.c"
#include "messages.c"
#include "gestures.c"
#include "macros.c"
#include "bodies.c"
#include "sum.c"
#include "carom.c"
