/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours that anatomists expect, by the words of a tissue's name: those of printed atlases since
 * Gray's Anatomy, in which arteries and what holds oxygenated blood are red, veins and what holds
 * the other blood blue, nerves and fat yellow, lymph and bile green, cartilage a pale blue, bone
 * ivory, and organs as they look in surgery. The deep nuclei of the brain have the hues of
 * FreeSurfer's FreeSurferColorLUT.txt, which readers of such pictures know. Lightness and chroma
 * are ours: they sit beside the palette of colors.c. */
#include "source.h"

#include <string.h>

/* What a name has to hold, and the colour. Every word of @c words has to be among those of the
 * name; "a|b" is either, "a*" what begins with a. */
typedef struct anatomy_rule {
    const char *words;
    uint8_t rgb[3];
} anatomy_rule;

/* The first rule that fits decides, so what is special stands before what is general. Parts of the
 * cortex of the brain (ctx-lh-insula) and of the white matter below them (wm-lh-insula) have none,
 * because all would look alike. */
static const anatomy_rule rules[] = {
    /* what does not belong there */
    {"tumor*|tumour*|lesion*|cancer|carcinoma|metasta*|neoplas*|glioma|melanoma|lymphoma|nodul*",
     {164, 184, 74}},
    {"cyst|cysts", {196, 196, 118}},
    {"stent|catheter|implant|pacemaker|prosthe*|screw|electrode*", {150, 156, 166}},
    {"calcif*|calculus|calculi|stone|stones", {242, 236, 220}},
    /* cartilage and bone, before the organs that they bear the names of */
    {"cartilag*|meniscus|menisci|disc|discs|disk|disks|labrum", {168, 198, 212}},
    {"ligament*|tendon*|fascia|aponeurosis", {222, 216, 200}},
    {"tooth|teeth|dental|enamel|incisor*|molar*|premolar*|fdi*", {244, 238, 222}},
    {"marrow", {192, 104, 92}},
    {"bone*|vertebra*|rib|ribs|costa|costae|skull|cranium|mandible|maxilla|sternum|manubrium|"
     "scapula*|"
     "clavicle*|clavicula*|humerus|radius|ulna|femur|tibia|fibula|patella|hip|hips|"
     "pelvis|sacrum|coccyx|ilium|ischium|pubis|carpal*|tarsal*|carpus|tarsus|metacarp*|metatars*|"
     "phalan*|"
     "talus|calcaneus|hyoid|zygoma*|spine|skeleton",
     {228, 212, 176}},
    /* vessels */
    {"pulmonary|pulmonal* artery|arteries|trunk|arteria*|truncus", {82, 116, 176}},
    {"pulmonary|pulmonal* vein|veins|venous|vena|venae", {198, 90, 78}},
    {"coronary sinus|vein|veins", {76, 106, 170}},
    {"sagittal|transverse|sigmoid|straight|cavernous sinus", {76, 106, 170}},
    {"portal|splenic vein|veins", {96, 116, 164}},
    {"coronary|coronaries", {206, 68, 58}},
    {"aort*", {198, 72, 64}},
    {"vein|veins|vena|venae|cava|ivc|svc|venous|jugular", {76, 106, 170}},
    {"artery|arteries|arterial|arteria*|carotid|brachiocephalic|lad|lcx|rca", {204, 78, 68}},
    {"vessel|vessels|vasculature|vascular", {190, 86, 80}},
    /* the heart */
    {"valve*|chorda*|papillary", {226, 206, 172}},
    {"myocard*|myo", {168, 76, 70}},
    {"pericardi*|epicardi*", {222, 196, 150}},
    {"lateral|third|fourth|3rd|4th|5th|inf|brain|cerebral ventric*|vent", {112, 168, 206}},
    {"left ventric*|atrium|atrial|auricle|auricular", {204, 96, 86}},
    {"right ventric*|atrium|atrial|auricle|auricular", {92, 122, 182}},
    {"lv", {204, 96, 86}},
    {"rv", {92, 122, 182}},
    {"heart|cardiac", {178, 84, 76}},
    /* nerves and the brain */
    {"csf|cerebrospinal|cistern*|choroid", {112, 168, 206}},
    {"spinal cord|canal", {226, 206, 112}},
    {"nerve|nerves|nervus|nervi|chiasm|plexus|ganglion|ganglia|cauda", {226, 206, 112}},
    {"hypointensit*|hyperintensit*|wmh", {186, 150, 196}},
    {"white matter", {236, 226, 204}},
    {"cerebral|cerebellar|cerebellum|cerebrum wm", {236, 226, 204}},
    {"callosum|fornix|commissure|fimbria|scp|peduncle*", {236, 226, 204}},
    {"internal|external|extreme capsule", {236, 226, 204}},
    {"cc anterior|mid|central|posterior", {236, 226, 204}}, /* of the corpus callosum */
    {"cerebellum|cerebellar|vermis|vermal", {200, 150, 134}},
    {"brainstem|stem|pons|medulla|midbrain|mesencephalon", {214, 186, 150}},
    {"ventral dc|diencephalon", {176, 104, 92}},
    {"substantia|substancia nigra", {118, 104, 112}},
    {"subthalamic", {190, 146, 110}},
    {"hypothalamus|hypothalamic|mammillary", {176, 104, 92}},
    {"thalamus", {92, 146, 92}},
    {"caudate", {130, 180, 206}},
    {"putamen", {206, 112, 162}},
    {"pallid*", {92, 108, 186}},
    {"hippocampus|hippocampi|hippocampal|subiculum", {210, 194, 92}},
    {"amygdala", {108, 190, 188}},
    {"accumbens", {218, 158, 88}},
    {"cerebral cortex", {206, 172, 158}},
    {"gray|grey matter", {206, 172, 158}},
    {"eye|eyes|eyeball*|sclera", {234, 230, 222}},
    {"lens|cornea|vitreous", {186, 210, 220}},
    /* breathing */
    {"lung|lungs|pulmo|pulmones", {220, 156, 148}},
    {"trachea|bronch*|airway|airways|larynx|sinus|sinuses|nasal", {150, 188, 204}},
    /* digestion */
    {"gallbladder|gall|bile|biliary|fellea|biliaris", {112, 146, 84}},
    {"liver|hepatic|hepar", {150, 82, 66}},
    {"pancrea*", {224, 184, 124}},
    {"spleen|lien", {134, 78, 106}},
    {"stomach|gastric", {212, 146, 128}},
    {"esophag*|oesophag*", {196, 142, 122}},
    {"duoden*", {212, 164, 124}},
    {"colon|caecum|cecum|rectum|appendix", {196, 152, 120}},
    {"bowel|intestin*|jejunum|ileum", {224, 174, 146}},
    {"tongue|pharyn*|oral", {198, 106, 102}},
    /* glands, urinary organs, reproduction */
    {"adrenal|suprarenal|adrenals", {220, 180, 98}},
    {"kidney*|renal|ren|renes", {158, 86, 74}},
    {"ureter|ureters|urethra", {224, 202, 136}},
    {"bladder|vesica", {222, 200, 142}},
    {"prostate", {200, 154, 144}},
    {"uterus|uterine|cervix|vagina", {204, 134, 130}},
    {"ovary|ovaries|testis|testes|testicle*", {222, 192, 168}},
    {"breast*|mamma*", {226, 184, 156}},
    {"thyroid", {178, 98, 80}},
    {"lymph*", {120, 168, 100}},
    {"gland*|parotid|salivary|submandibular|thymus|pituitary", {224, 194, 144}},
    /* the rest of the body */
    {"muscle*|muscul*|diaphragm|gluteus|iliopsoas|psoas|autochthon|masseter|temporalis|"
     "pterygoid|sternocleidomastoid|trapezius|deltoid|pectoralis|biceps|triceps|quadriceps|"
     "hamstring*|sartorius|gracilis|gastrocnemius|soleus|abdominis",
     {172, 80, 72}},
    {"fat|adipose|subcutaneous|subcutis", {236, 212, 130}},
    {"skin|epidermis|dermis|cutis", {219, 190, 171}},
    {"brain|cerebrum", {222, 194, 178}},
};

/* @return whether @p c belongs to a word. Bytes from 128 on are parts of letters in UTF-8. */
static bool in_word(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (unsigned char)c >= 128;
}

/* Write the words of a name to @p out in small letters, with a blank before and behind each. A
 * large letter behind a small one begins a word. */
static void split_words(const char *name, char out[2 * SC_NAME_BYTES + 2])
{
    size_t n = 0;
    char last = ' ';

    out[n++] = ' ';
    for (const char *c = name; *c; c++) {
        const bool is_large = *c >= 'A' && *c <= 'Z';

        if (!in_word(*c)) {
            last = ' ';
            continue;
        }
        if (n > 1 && (last == ' ' || (is_large && last >= 'a' && last <= 'z')))
            out[n++] = ' ';
        out[n++] = is_large ? (char)(*c - 'A' + 'a') : *c;
        last = *c;
    }
    out[n++] = ' ';
    out[n] = '\0';
}

/* @return whether the words of a name, of split_words, hold one that is the @p length characters at
 * @p word, or, if these end in "*", one that begins with those before it. */
static bool has_word(const char *words, const char *word, size_t length)
{
    const bool is_beginning = word[length - 1] == '*';
    const size_t compared = is_beginning ? length - 1 : length;

    for (const char *at = words; (at = strchr(at, ' ')) != NULL;) {
        at++;
        if (strncmp(at, word, compared) == 0 && (is_beginning || at[compared] == ' '))
            return true;
    }
    return false;
}

/* @return whether the words of a name hold all that a rule asks for. */
static bool rule_fits(const char *words, const char *rule)
{
    while (*rule) {
        const size_t group = strcspn(rule, " ");
        bool found = false;

        for (size_t i = 0; i < group && !found;) {
            const size_t length = strcspn(rule + i, "| ");

            found = has_word(words, rule + i, length);
            i += length + 1;
        }
        if (!found)
            return false;
        rule += group + (rule[group] == ' ');
    }
    return true;
}

/* Abbreviations of the heart, of which some mean other things elsewhere: LA and RA are nuclei of
 * the amygdala in atlases of the brain. */
static const anatomy_rule heart_rules[] = {
    {"la|laa", {204, 96, 86}},  {"ra|raa", {92, 122, 182}}, {"ao", {198, 72, 64}},
    {"pa|mpa", {82, 116, 176}}, {"pv|pvs", {198, 90, 78}},  {"lvm", {168, 76, 70}},
};

/* Write the colour of the first rule that fits the words of a name, of split_words. @return whether
 * one does. */
static bool color_by_rules(const char *words, const anatomy_rule *list, size_t count,
                           uint8_t rgb[3])
{
    for (size_t i = 0; i < count; i++) {
        if (rule_fits(words, list[i].words)) {
            memcpy(rgb, list[i].rgb, sizeof list[i].rgb);
            return true;
        }
    }
    return false;
}

bool sc_anatomy_color(const char *name, bool of_heart, uint8_t rgb[3])
{
    char words[2 * SC_NAME_BYTES + 2];

    split_words(name, words);
    return color_by_rules(words, rules, SC_COUNT_OF(rules), rgb) ||
           (of_heart && color_by_rules(words, heart_rules, SC_COUNT_OF(heart_rules), rgb));
}

bool sc_names_are_of_heart(const sc_label *labels, int count)
{
    char words[2 * SC_NAME_BYTES + 2];
    bool left = false, right = false;

    for (int id = 0; id < count; id++) {
        split_words(labels[id].name, words);
        left |= rule_fits(words, "lv");
        right |= rule_fits(words, "rv");
    }
    return left && right;
}
