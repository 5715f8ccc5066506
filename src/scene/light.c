/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/scene.h"

sc_lighting sc_lighting_default(void)
{
    return (sc_lighting){
        .ambient = 0.28, .key = 0.62, .fill = 0.16, .head = 0.22, .occlusion = 0.8, .edges = 0.5};
}
