/* SPDX-License-Identifier: BSD-3-Clause */
/* The order in which an anatomist lists tissues: by system of the body, from the head to the feet.
 */
#include "init/init.h"

#include <stdlib.h>

const char *sc_system_title(sc_system system)
{
    static const char *const titles[SC_SYSTEM_COUNT] = {
        [SC_SYSTEM_COVERS] = "Around the others, from the outside",
        [SC_SYSTEM_SKELETON] = "Skeleton",
        [SC_SYSTEM_MUSCLES] = "Muscles",
        [SC_SYSTEM_HEART] = "Heart",
        [SC_SYSTEM_VESSELS] = "Vessels",
        [SC_SYSTEM_AIRWAYS] = "Airways and lungs",
        [SC_SYSTEM_DIGESTIVE] = "Digestive organs",
        [SC_SYSTEM_UROGENITAL] = "Urinary and genital organs",
        [SC_SYSTEM_GLANDS] = "Glands, spleen and lymph",
        [SC_SYSTEM_NERVES] = "Brain, nerves and eyes",
        [SC_SYSTEM_OTHER] = "Other tissues"};

    return titles[system];
}

/* Beginnings of words in the names of tissues, "|" between them, and the system that they tell. The
 * first row with one that fits decides: "coronary artery" is a vessel, "renal cortex" no brain. */
static const struct {
    const char *beginnings;
    sc_system system;
} words_of_systems[] = {
    {"rectus|oblique|sternocleido|longus|capitis|masseter|pterygoid|temporalis|trapez|scalen|"
     "digastric|levator|nasalis|splenius|semispin|platysma|buccinat|orbicular|geniogloss|muscle",
     SC_SYSTEM_MUSCLES},
    {"pellucid", SC_SYSTEM_NERVES},
    {"aortic valve|pulmonary valve|pulmonic valve", SC_SYSTEM_HEART},
    {"kidney|renal|ureter|urin|urethr|prostat|uter|ovar|testi|seminal|vagin|cervix",
     SC_SYSTEM_UROGENITAL},
    {"adrenal|thyroid|parathyroid|pituitar|spleen|thymus|lymph|tonsil|salivar|parotid|submandib",
     SC_SYSTEM_GLANDS},
    {"arter|aort|vein|vena|venous|vessel|vascul|portal|carotid|subclavian|brachiocephalic|azygos|"
     "sinus|blood|pulmonary trunk|pulmonary vein",
     SC_SYSTEM_VESSELS},
    {"liver|hepat|stomach|gastr|duoden|jejun|ileum|bowel|intestin|colon|rectum|esophag|oesophag|"
     "pancrea|gallblad|tongue|appendix|bile|caecum|cecum|pharyn",
     SC_SYSTEM_DIGESTIVE},
    {"lateral ventricle|third ventricle|fourth ventricle|3rd ventricle|4th ventricle|5th "
     "ventricle|inf lat "
     "vent|cerebr|cerebel|brain|gyrus|sulcus|thalam|hypothal|hippocamp|amygdal|putamen|caudate|"
     "pallid|globus|corpus callos|white matter|gray matter|grey matter|csf|nerve|spinal "
     "cord|pons|medulla|fornix|nucle|insula|optic|cortex|accumbens|vermis|choroid|eye|lens|retina|"
     "ctx|dura|temporal pole|frontal pole|claustrum|fasciculus|tract|lobule|precuneus|cuneus",
     SC_SYSTEM_NERVES},
    {"heart|atri|ventric|myocard|pericard|endocard|epicard|valve|septum|cardiac|papillary|mitral|"
     "tricuspid|auricle",
     SC_SYSTEM_HEART},
    {"lung|trache|bronch|laryn|airway|pulmonary|pleura|nasal|nose|diaphragm", SC_SYSTEM_AIRWAYS},
    {"musc|glute|iliopsoas|psoas|autochthon|quadricep|thigh|sartorius|deltoid|pector|tendon",
     SC_SYSTEM_MUSCLES},
    {"bone|skull|crani|vertebra|rib|femur|hip|sacr|scapul|clavic|humer|stern|costal|pelvis|tibia|"
     "fibula|patella|radius|ulna|mandib|maxill|tooth|teeth|jaw|cartilage|disc|disk|skelet|carpal|"
     "tarsal|phalan|coccyx|ilium|ischium|spine",
     SC_SYSTEM_SKELETON},
    {"bladder|penis", SC_SYSTEM_UROGENITAL},
};

/* @return the system that the words of a name tell. */
static sc_system system_of(const char *words)
{
    for (size_t i = 0; i < SC_COUNT_OF(words_of_systems); i++) {
        const char *at = words_of_systems[i].beginnings;

        while (*at) {
            char beginning[32];
            const size_t length = strcspn(at, "|");

            snprintf(beginning, sizeof beginning, "%.*s", (int)length, at);
            if (sc_word_begins(words, beginning))
                return words_of_systems[i].system;
            at += length + (at[length] == '|');
        }
    }
    return SC_SYSTEM_OTHER;
}

/* Fill the side and the stem of a place from the words of its name. */
static void split_name(const char *words, sc_place *place)
{
    static const struct {
        const char *word;
        int side;
    } sides[] = {{"right", 0}, {"r", 0}, {"rh", 0}, {"left", 1}, {"l", 1}, {"lh", 1}};
    size_t used = 0;

    place->side = 2;
    while (*words) {
        const size_t length = strcspn(words, " ");
        bool keep = strcspn(words, "0123456789") >= length;

        for (size_t i = 0; i < SC_COUNT_OF(sides); i++) {
            if (strlen(sides[i].word) == length && !strncmp(words, sides[i].word, length)) {
                place->side = sides[i].side;
                keep = false;
            }
        }
        if (keep)
            used += (size_t)snprintf(place->stem + used, sizeof place->stem - used, "%.*s ",
                                     (int)length, words);
        words += length + (words[length] == ' ');
    }
}

/* @return the height of the middle of a tissue's bounding box. */
static double height_of(const sc_prepared *v, int id)
{
    const sc_label_stats *s = &v->stats[id];
    const sc_vec3 middle = {0.5 * (s->low[0] + s->high[0]), 0.5 * (s->low[1] + s->high[1]),
                            0.5 * (s->low[2] + s->high[2])};

    return sc_affine_point(&v->to_ras_mm, middle).z;
}

/* For qsort: by system, then by stem. */
static int by_stem(const void *a, const void *b)
{
    const sc_place *x = a, *y = b;

    return x->system != y->system ? (int)x->system - (int)y->system : strcmp(x->stem, y->stem);
}

static int rising(double a, double b)
{
    return (a > b) - (a < b);
}

/* For qsort: in the order of the job file. */
static int by_place(const void *a, const void *b)
{
    const sc_place *x = a, *y = b;
    int order = (int)x->system - (int)y->system;

    if (!order)
        order = x->layer - y->layer;
    if (!order)
        order = rising(y->group_mm, x->group_mm);
    if (!order)
        order = strcmp(x->stem, y->stem);
    if (!order)
        order = x->side - y->side;
    if (!order)
        order = rising(y->height_mm, x->height_mm);
    return order ? order : x->id - y->id;
}

/* Give the places of each stem the largest height among them. Those without a stem have their own.
 * @param places [count], sorted by stem. */
static void find_groups(sc_place *places, int count)
{
    for (int begin = 0, end; begin < count; begin = end) {
        double highest = places[begin].height_mm;

        for (end = begin + 1;
             end < count && places[begin].stem[0] && !by_stem(&places[begin], &places[end]); end++)
            highest = places[end].height_mm > highest ? places[end].height_mm : highest;
        for (int i = begin; i < end; i++)
            places[i].group_mm = highest;
    }
}

sc_status sc_places_find(const sc_ctx *ctx, const sc_prepared *volume, const int *layers,
                         sc_place **out, int *count)
{
    sc_place *places;
    int found = 0;

    SC_PASS(SC_ZALLOC(ctx, (size_t)volume->label_count, &places));
    for (int id = 1; id < volume->label_count; id++) {
        sc_place *place = &places[found];
        char words[SC_NAME_BYTES];

        if (volume->stats[id].voxels == 0)
            continue;
        sc_plain_words(volume->labels[id].name, words);
        place->id = id;
        place->layer = layers[id];
        place->system = layers[id] ? SC_SYSTEM_COVERS : system_of(words);
        place->height_mm = height_of(volume, id);
        split_name(words, place);
        found++;
    }
    qsort(places, (size_t)found, sizeof *places, by_stem);
    find_groups(places, found);
    qsort(places, (size_t)found, sizeof *places, by_place);
    *out = places;
    *count = found;
    return SC_OK;
}
