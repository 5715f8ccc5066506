/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours that anatomists expect, by the words of a tissue's name: those of printed atlases since
 * Gray's Anatomy, in which arteries and what holds oxygenated blood are red, veins and what holds
 * the other blood blue, nerves and fat yellow, lymph and bile green, cartilage a pale blue, bone
 * ivory, and organs as they look in surgery. The deep nuclei of the brain have the hues of
 * FreeSurfer's FreeSurferColorLUT.txt, which readers of such pictures know. Lightness and chroma
 * are ours: they sit beside the palette of colors.c. */
#include "source.h"

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
    {"other|others|rest|remain*|unclass*|unspecified", {219, 190, 171}}, /* as skin */
    {"stent|catheter|implant|pacemaker|prosthe*|screw|electrode*", {150, 156, 166}},
    {"calcif*|calculus|calculi|stone|stones", {242, 236, 220}},
    /* cartilage and bone, before the organs that they bear the names of */
    {"cartilage|cartilages|meniscus|menisci|disc|discs|disk|disks|labrum", {168, 198, 212}},
    {"ligament*|tendon*|fascia|aponeurosis", {222, 216, 200}},
    {"tooth|teeth|dental|enamel|incisor*|molar*|premolar*|fdi*", {244, 238, 222}},
    {"marrow", {192, 104, 92}},
    {"bone*|vertebra*|rib|ribs|skull|cranium|mandible|maxilla|sternum|manubrium|"
     "scapula*|"
     "clavicle*|clavicula*|humerus|radius|ulna|femur|tibia|fibula|patella|hip|hips|"
     "pelvis|sacrum|coccyx|ilium|ischium|pubis|carpal*|tarsal*|carpus|tarsus|metacarp*|metatars*|"
     "phalan*|"
     "talus|calcaneus|hyoid|zygoma*|spine|skeleton",
     {228, 212, 176}},
    /* vessels */
    {"pulmonary artery|arteries|trunk", {82, 116, 176}},
    {"pulmonary vein|veins|venous", {198, 90, 78}},
    {"coronary sinus|vein|veins", {76, 106, 170}},
    {"sagittal|transverse|sigmoid|straight|cavernous sinus", {76, 106, 170}},
    {"portal|splenic vein|veins", {96, 116, 164}},
    {"coronary|coronaries", {206, 68, 58}},
    {"aort*", {198, 72, 64}},
    {"vein|veins|cava|venous|jugular", {76, 106, 170}},
    {"artery|arteries|arterial|carotid|brachiocephalic", {204, 78, 68}},
    {"vessel|vessels|vasculature|vascular", {190, 86, 80}},
    /* the heart */
    {"valve*|chorda*|papillary", {226, 206, 172}},
    {"myocard*", {168, 76, 70}},
    {"pericardi*|epicardi*", {222, 196, 150}},
    {"lateral|third|fourth|3rd|4th|5th|inf|brain|cerebral ventric*|vent", {112, 168, 206}},
    {"left ventric*|atrium|atrial|auricle|auricular", {204, 96, 86}},
    {"right ventric*|atrium|atrial|auricle|auricular", {92, 122, 182}},
    {"heart|cardiac", {178, 84, 76}},
    /* nerves and the brain */
    {"csf|cerebrospinal|cistern*|choroid", {112, 168, 206}},
    {"spinal cord|canal", {226, 206, 112}},
    {"nerve|nerves|chiasm|plexus|ganglion|ganglia|cauda", {226, 206, 112}},
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
    {"lung|lungs", {230, 170, 166}},
    {"trachea|bronch*|airway|airways|larynx|sinus|sinuses|nasal", {150, 188, 204}},
    /* digestion */
    {"gallbladder|gall|bile|biliary", {112, 146, 84}},
    {"liver|hepatic", {134, 72, 54}},
    {"pancrea*", {224, 184, 124}},
    {"spleen", {126, 70, 104}},
    {"stomach|gastric", {200, 118, 112}},
    {"esophag*|oesophag*", {196, 142, 122}},
    {"duoden*", {218, 150, 108}},
    {"colon|caecum|cecum|rectum|appendix", {214, 158, 140}},
    {"bowel|intestin*|jejunum|ileum", {238, 186, 172}},
    {"tongue|pharyn*|oral", {198, 106, 102}},
    /* glands, urinary organs, reproduction */
    {"adrenal|suprarenal|adrenals", {220, 180, 98}},
    {"kidney*|renal", {196, 112, 104}},
    {"ureter|ureters|urethra", {224, 202, 136}},
    {"bladder", {222, 200, 142}},
    {"prostate", {200, 154, 144}},
    {"uterus|uterine|cervix|vagina", {204, 134, 130}},
    {"ovary|ovaries|testis|testes|testicle*", {222, 192, 168}},
    {"breast*|mamma*", {226, 184, 156}},
    {"thyroid", {178, 98, 80}},
    {"lymph*", {120, 168, 100}},
    {"gland*|parotid|salivary|submandibular|thymus|pituitary", {224, 194, 144}},
    /* the rest of the body */
    {"muscle*|musculature|diaphragm|gluteus|iliopsoas|psoas|autochthon|masseter|temporalis|"
     "pterygoid|sternocleidomastoid|trapezius|deltoid|pectoralis|biceps|triceps|quadriceps|"
     "hamstring*|sartorius|gracilis|gastrocnemius|soleus|abdominis",
     {172, 78, 74}},
    {"fat|adipose|subcutaneous|subcutis", {236, 212, 130}},
    {"skin|epidermis|dermis|cutis", {219, 190, 171}},
    {"brain|cerebrum", {222, 194, 178}},
};

/* Words of which names in a brain have one. Those of lobes are also those of bones, so that only a
 * volume counts as a brain of which half of the names have one. */
static const char brain_words[] =
    "ctx|wm|cortex|cortical|gyrus|gyri|sulcus|sulci|lobule|operculum|cerebral|cerebrum|cerebell*|"
    "thalamus|hypothalamus|hippocamp*|parahippocamp*|amygdala|putamen|caudate|pallid*|accumbens|"
    "insula|cuneus|precuneus|precentral|postcentral|paracentral|frontal|temporal|occipital|"
    "parietal|cingul*|fusiform|lingual|calcarine|angular|supramarginal|vermis|callosum|brainstem|"
    "pons|midbrain|nucleus|csf|cc|dc|vent|choroid|brain|stem";

/* Words of Latin or abbreviations, "|" between them, and the words of the rules that they stand
 * for. */
typedef struct anatomy_term {
    const char *words, *english;
} anatomy_term;

/* Latin is that of Terminologia Anatomica (FIPAT, 2nd edition, 2019), in the forms of singular and
 * plural that stand in names; lien and auricula are of the edition before. Precava and postcava are
 * the venae cavae of comparative anatomy. Abbreviations are those of the coronary segments of the
 * Society of Cardiovascular Computed Tomography (Leipsic et al. 2014), and for other vessels those
 * that are usual in reports of CT. */
static const anatomy_term terms[] = {
    /* sides */
    {"dexter|dextra|dextrum|dextri|dx", "right"},
    {"sinister|sinistra|sinistrum|sinistri|sin", "left"},
    /* kinds of tissue */
    {"arteria|arteriae", "artery"},
    {"vena|venae", "vein"},
    {"truncus", "trunk"},
    {"vas|vasa", "vessel"},
    {"nervus|nervi", "nerve"},
    {"musculus|musculi", "muscle"},
    {"os|ossa", "bone"},
    {"costa|costae", "rib"},
    {"cartilago|cartilagines", "cartilage"},
    {"ligamentum", "ligament"},
    {"tendo", "tendon"},
    {"dens|dentes", "tooth"},
    {"glandula", "gland"},
    {"nodus|nodi", "lymph"},
    {"cutis", "skin"},
    /* organs */
    {"cor", "heart"},
    {"valva", "valve"},
    {"auricula", "auricle"},
    {"coronaria|coronariae", "coronary"},
    {"pulmonalis|pulmonales", "pulmonary"},
    {"carotis", "carotid"},
    {"portae", "portal"},
    {"pulmo|pulmones", "lung"},
    {"hepar", "liver"},
    {"fellea|biliaris", "gall"},
    {"choledochus", "bile"},
    {"splen|lien", "spleen"},
    {"gaster", "stomach"},
    {"ren|renes", "kidney"},
    {"suprarenalis", "suprarenal"},
    {"vesica", "bladder"},
    {"thyroidea", "thyroid"},
    {"lingua", "tongue"},
    {"oculus|bulbi", "eye"},
    {"spinalis", "spinal cord"},
    /* vessels */
    {"gda", "gastroduodenal artery"},
    {"cca|eca", "carotid artery"},
    {"precava|svc|postcava|ivc|ijv", "vein"},
    {"lad|lcx|rca", "coronary"},
    {"laa", "left atrium"},
    {"raa", "right atrium"},
    {"lvm|myo", "myocardium"},
    {"lv", "left ventricle"},
    {"rv", "right ventricle"},
};

/* Abbreviations of the heart that mean other things elsewhere: LA is a nucleus of the amygdala. */
static const anatomy_term heart_terms[] = {
    {"la", "left atrium"},          {"ra", "right atrium"},       {"ao", "aorta"},
    {"pa|mpa", "pulmonary artery"}, {"pv|pvs", "pulmonary vein"},
};

/* Abbreviations that mean other things in a brain: SMA is its supplementary motor area. */
static const anatomy_term body_terms[] = {{"sma|ima", "mesenteric artery"},
                                          {"smv|imv", "mesenteric vein"}};

/* @return whether @p c belongs to a word. Bytes from 128 on are parts of letters in UTF-8. */
static bool in_word(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (unsigned char)c >= 128;
}

enum { WORDS_BYTES = 4 * SC_NAME_BYTES };

/* @return the English words that a word of a list stands for, or NULL. */
static const char *find_term(const anatomy_term *list, size_t count, const char *word)
{
    for (size_t i = 0; i < count; i++) {
        for (const char *at = list[i].words; *at; at += strcspn(at, "|"), at += *at == '|') {
            if (strcspn(at, "|") == strlen(word) && !strncmp(at, word, strlen(word)))
                return list[i].english;
        }
    }
    return NULL;
}

/* Append a word and a blank to those in @p out, in English if a list knows it, unless there is no
 * room. */
static void add_english(const char *word, sc_names_kind kind, char out[WORDS_BYTES])
{
    const char *english = find_term(terms, SC_COUNT_OF(terms), word);
    const size_t used = strlen(out);

    if (!english && kind == SC_NAMES_HEART)
        english = find_term(heart_terms, SC_COUNT_OF(heart_terms), word);
    if (!english && kind != SC_NAMES_BRAIN)
        english = find_term(body_terms, SC_COUNT_OF(body_terms), word);
    english = english ? english : word;
    if (used + strlen(english) + 2 <= WORDS_BYTES)
        snprintf(out + used, WORDS_BYTES - used, "%s ", english);
}

/* Write the words of a name to @p out in small letters and in English, with a blank before and
 * behind each. A large letter behind a small one begins a word. */
static void split_words(const char *name, sc_names_kind kind, char out[WORDS_BYTES])
{
    char word[SC_NAME_BYTES];
    size_t n = 0;

    memcpy(out, " ", 2);
    for (const char *c = name;; c++) {
        const bool is_large = *c >= 'A' && *c <= 'Z';
        const bool begins = is_large && n > 0 && c[-1] >= 'a' && c[-1] <= 'z';

        if (n > 0 && (begins || !in_word(*c))) {
            word[n] = '\0';
            add_english(word, kind, out);
            n = 0;
        }
        if (!*c)
            return;
        if (in_word(*c))
            word[n++] = is_large ? (char)(*c - 'A' + 'a') : *c;
    }
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

bool sc_anatomy_color(const char *name, sc_names_kind kind, uint8_t rgb[3])
{
    char words[WORDS_BYTES];

    split_words(name, kind, words);
    for (size_t i = 0; i < SC_COUNT_OF(rules); i++) {
        if (rule_fits(words, rules[i].words)) {
            memcpy(rgb, rules[i].rgb, sizeof rules[i].rgb);
            return true;
        }
    }
    return false;
}

sc_name_role sc_name_role_of(const char *name)
{
    static const char rest[] = "other|others|unknown|background|unclass*|unlabel*|unspecified|"
                               "undefin*|remain*|rest|exterior";
    static const char *const outsides[] = {"skin|subcut*|outside", "soft tissue|tissues",
                                           "body trunc|extremities"};
    char words[WORDS_BYTES];
    bool found;

    split_words(name, SC_NAMES_BODY, words);
    if (rule_fits(words, rules[0].words)) /* a tumour of the skin */
        return SC_NAME_PART;
    if (rule_fits(words, rest))
        return SC_NAME_REST;
    found = !strcmp(words, " body ") || !strcmp(words, " head ");
    for (size_t i = 0; i < SC_COUNT_OF(outsides); i++)
        found = found || rule_fits(words, outsides[i]);
    return found ? SC_NAME_OUTSIDE : SC_NAME_PART;
}

/* @return how many @p labels [count] lie between two values, inclusive. */
static int count_between(const sc_label *labels, int count, int64_t low, int64_t high)
{
    int found = 0;

    for (int id = 1; id < count; id++)
        found += labels[id].value >= low && labels[id].value <= high;
    return found;
}

/* Are the numbers of @p labels [count] those of FreeSurfer: regions of the cortex, left from 1001
 * on and right from 2001 on, or at least four structures below it on both sides, and none of the
 * numbers between them that its volumes never have? */
static bool has_numbers_of_freesurfer(const sc_label *labels, int count)
{
    static const int pairs[][2] = {{2, 41},  {3, 42},  {4, 43},  {7, 46},  {8, 47},  {10, 49},
                                   {11, 50}, {12, 51}, {13, 52}, {17, 53}, {18, 54}, {26, 58}};
    static const int never[][2] = {{6, 6},   {9, 9},   {19, 23},  {32, 40},
                                   {45, 45}, {48, 48}, {256, 999}};
    int both = 0;

    for (size_t i = 0; i < SC_COUNT_OF(never); i++) {
        if (count_between(labels, count, never[i][0], never[i][1]))
            return false;
    }
    for (size_t i = 0; i < SC_COUNT_OF(pairs); i++)
        both += count_between(labels, count, pairs[i][0], pairs[i][0]) &&
                count_between(labels, count, pairs[i][1], pairs[i][1]);
    return both >= 4 || (count_between(labels, count, 1001, 1035) >= 8 &&
                         count_between(labels, count, 2001, 2035) >= 8);
}

sc_names_kind sc_names_kind_of(const sc_label *labels, int count)
{
    int left = 0, right = 0, brain = 0, named = 0;

    for (int id = 1; id < count; id++) {
        char words[WORDS_BYTES];

        split_words(labels[id].name, SC_NAMES_BODY, words);
        if (!rule_fits(words, "lateral|inf|inferior")) { /* of the brain */
            left += rule_fits(words, "left ventricle");
            right += rule_fits(words, "right ventricle");
        }
        brain += rule_fits(words, brain_words);
        named += labels[id].name[0] != '\0';
    }
    if (named ? named > 1 && 2 * brain >= named : has_numbers_of_freesurfer(labels, count))
        return SC_NAMES_BRAIN;
    return left && right ? SC_NAMES_HEART : SC_NAMES_BODY;
}

void sc_name_without_side(const char *name, sc_names_kind kind, char out[SC_NAME_KEY_BYTES])
{
    enum { DIGITS = 4 };
    char words[WORDS_BYTES], zeros[] = "0000";

    split_words(name, kind, words);
    out[0] = '\0';
    for (const char *word = words + 1; *word; word += strcspn(word, " ") + 1) {
        const size_t length = strcspn(word, " "), head = strcspn(word, "0123456789 ");
        const size_t digits = strspn(word + head, "0123456789");
        const size_t used = strlen(out), added = digits && digits < DIGITS ? DIGITS - digits : 0;

        if (has_word(" left right l r lh rh ", word, length) ||
            used + length + added + 2 > SC_NAME_KEY_BYTES)
            continue;
        snprintf(out + used, SC_NAME_KEY_BYTES - used, "%.*s%.*s%.*s ", (int)head, word, (int)added,
                 zeros, (int)(length - head), word + head);
    }
}
