/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to scene: names of tissues as they are compared. */
#ifndef SC_SCENE_MATCH_H
#define SC_SCENE_MATCH_H

#include "segcast/scene.h"

/* Write the words of a name: ASCII letters in lower case, a single blank where blanks, "_" or "-"
 * separate words, and none at its ends. */
void sc_words_of_name(const char *name, char out[SC_NAME_BYTES]);

#endif
