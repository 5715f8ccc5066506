/* SPDX-License-Identifier: BSD-3-Clause */
/* The prepared volume as one block, in memory or as a file: a header, then one section per array,
 * at 64-byte boundaries. Arrays of structs are written as they stand in memory. */
#include "internal.h"

#include "segcast/image.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

enum { ALIGN_BYTES = 64, VERSION = 11, BYTE_ORDER_MARK = 0x01020304 };

/* The arrays of sc_prepared, then those of its sc_stored, in their order in the block. */
enum {
    IDS,
    LABELS,
    STATS,
    NEAR,
    NEAR_START,
    OUTER_MASKS,
    OUTER_START,
    OUTER_RECORDS,
    INNER_MASKS,
    INNER_START,
    INNER_RECORDS,
    THICKNESS,
    HIDDEN,
    SMOOTH,
    CELL_MASKS,
    CELL_START,
    CELLS,
    DISTANCES,
    HULL,
    OCCLUSION,
    OPACITY,
    SECTIONS /* how many there are */
};

/* What of sc_stored a file holds, as bits of a header: all but the occlusion, and that too. */
enum { STORED_CELLS = 1, STORED_OCCLUSION = 2 };

static const char magic[8] = "segcprep";

/* Readers of a block rely on these layouts. Who changes one must raise VERSION, so that files of
 * the old layout are refused. */
_Static_assert(sizeof(sc_label) == 280 && offsetof(sc_label, name) == 8 &&
                   offsetof(sc_label, rgb) == 264 && offsetof(sc_label, opacity) == 272,
               "sc_label has changed: raise VERSION");
_Static_assert(sizeof(sc_label_stats) == 72 && offsetof(sc_label_stats, thickness_mm) == 16 &&
                   offsetof(sc_label_stats, low) == 32 && offsetof(sc_label_stats, shown) == 56,
               "sc_label_stats has changed: raise VERSION");
_Static_assert(sizeof(sc_vec3) == 24, "sc_vec3 has changed: raise VERSION");
_Static_assert(SC_RECORD_BYTES == sizeof(uint32_t) && sizeof(sc_packed_cell) == 12 &&
                   SC_BRICK_VERTICES == 64,
               "the layout of records, cells or bricks has changed: raise VERSION");

/* What every version begins with. */
typedef struct block_format {
    char magic[8];
    uint32_t version, byte_order, header_bytes;
} block_format;

/* What is there of sc_stored. */
typedef struct stored_header {
    uint64_t parts; /* STORED_CELLS and STORED_OCCLUSION, or 0 */
    uint64_t cell_count, hull_count;
} stored_header;

/* The first bytes of a block. The fields are those of sc_prepared of the same name. */
typedef struct block_header {
    block_format format;
    int32_t size[3], bricks[3];
    int32_t label_bytes, label_count, oriented, local_thickness, resampled, as_drawn, numbered;
    sc_affine to_ras_mm;
    uint64_t volume_hash, boundary_count, near_count, outer_count, inner_count, total_bytes;
    uint64_t offset[SECTIONS]; /* by section, from the begin of the block */
    stored_header stored;
    uint64_t checksum; /* of files: of the header with 0 here, then of each section */
} block_header;
_Static_assert(sizeof(block_header) % sizeof(uint64_t) == 0 &&
                   offsetof(block_header, checksum) + sizeof(uint64_t) == sizeof(block_header),
               "the header ends with the checksum, without a gap");

/* @return @p bytes rounded up to a multiple of ALIGN_BYTES. */
static uint64_t aligned(uint64_t bytes)
{
    return (bytes + ALIGN_BYTES - 1) / ALIGN_BYTES * ALIGN_BYTES;
}

/* Write the lengths of the sections of sc_stored to @p bytes. */
static void measure_stored(const block_header *h, uint64_t bytes[SECTIONS])
{
    const bool cells = h->stored.parts & STORED_CELLS,
               occlusion = h->stored.parts & STORED_OCCLUSION;
    int framed[3];
    uint64_t bricks;

    sc_framed_size(h->bricks, framed);
    bricks = sc_brick_count(framed);
    bytes[CELL_MASKS] = cells ? bricks * sizeof(uint64_t) : 0;
    bytes[CELL_START] = cells ? bricks * sizeof(uint32_t) : 0;
    bytes[CELLS] = h->stored.cell_count * sizeof(sc_packed_cell);
    bytes[DISTANCES] = cells ? bricks : 0;
    bytes[HULL] = h->stored.hull_count * sizeof(sc_vec3);
    bytes[OCCLUSION] = occlusion ? 2 * bricks : 0;
    bytes[OPACITY] = occlusion ? (uint64_t)h->label_count * sizeof(float) : 0;
}

/* Find where the sections of a block lie and how long they are, from the sizes and counts in its
 * header, which must be set: fills offset and total_bytes of the header, and the lengths in @p
 * bytes, without the bytes that follow an array for gathers. */
static void lay_out(block_header *h, uint64_t bytes[SECTIONS])
{
    const uint64_t voxels = (uint64_t)h->size[0] * (uint64_t)h->size[1] * (uint64_t)h->size[2];
    const uint64_t bricks = sc_brick_count(h->bricks);

    bytes[IDS] = voxels * (uint64_t)h->label_bytes;
    bytes[LABELS] = (uint64_t)h->label_count * sizeof(sc_label);
    bytes[STATS] = (uint64_t)h->label_count * sizeof(sc_label_stats);
    bytes[NEAR] = bricks * sizeof(uint64_t);
    bytes[NEAR_START] = bricks * sizeof(uint32_t);
    bytes[OUTER_MASKS] = bytes[INNER_MASKS] = bytes[NEAR];
    bytes[OUTER_START] = bytes[INNER_START] = bytes[NEAR_START];
    bytes[OUTER_RECORDS] = h->outer_count * SC_RECORD_BYTES;
    bytes[INNER_RECORDS] = h->inner_count * SC_RECORD_BYTES;
    bytes[THICKNESS] = h->local_thickness ? h->near_count : 0;
    bytes[HIDDEN] = (uint64_t)h->label_count;
    bytes[SMOOTH] = (uint64_t)h->label_count * sizeof(sc_vec3);
    measure_stored(h, bytes);
    h->total_bytes = aligned(h->format.header_bytes);
    for (int i = 0; i < SECTIONS; i++) {
        h->offset[i] = h->total_bytes;
        h->total_bytes += aligned(bytes[i] + SC_GATHER_BYTES);
    }
}

/* @return the header of a preparation's block, or of its file, with 0 as checksum. Writes the
 * lengths of the sections to @p bytes. */
static block_header header_of(const sc_preparation *p, bool file, uint64_t bytes[SECTIONS])
{
    const sc_volume *v = p->volume;
    block_header h;

    memset(&h, 0, sizeof h); /* also the gaps between the fields, which are written too */
    memcpy(h.format.magic, magic, sizeof magic);
    h.format.version = VERSION;
    h.format.byte_order = BYTE_ORDER_MARK;
    h.format.header_bytes = sizeof h;
    memcpy(h.size, v->size, sizeof h.size);
    memcpy(h.bricks, p->bricks, sizeof h.bricks);
    h.label_bytes = v->label_bytes;
    h.label_count = v->label_count;
    h.oriented = v->oriented;
    h.local_thickness = p->thickness != NULL;
    h.resampled = p->settings.resampled;
    h.as_drawn = p->settings.as_drawn;
    h.numbered = v->numbered;
    h.to_ras_mm = v->to_ras_mm;
    h.volume_hash = p->volume_hash;
    h.boundary_count = p->boundary_count;
    h.near_count = p->near_count;
    h.outer_count = p->outer.count;
    h.inner_count = p->inner.count;
    if (file && p->stored.masks) {
        h.stored.parts = STORED_CELLS | (p->stored.occlusion ? STORED_OCCLUSION : 0);
        h.stored.cell_count = p->stored.cell_count;
        h.stored.hull_count = p->stored.hull_count;
    }
    lay_out(&h, bytes);
    return h;
}

size_t sc_preparation_bytes(const sc_preparation *preparation)
{
    uint64_t bytes[SECTIONS];

    return header_of(preparation, false, bytes).total_bytes;
}

uint64_t sc_preparation_file_bytes(const sc_preparation *preparation)
{
    uint64_t bytes[SECTIONS];

    return header_of(preparation, true, bytes).total_bytes;
}

/* Write the array of each section, borrowed from preparation and volume, to @p out. */
static void sources_of(const sc_preparation *p, const void *out[SECTIONS])
{
    const void *const sources[SECTIONS] = {
        [IDS] = p->volume->ids,
        [LABELS] = p->volume->labels,
        [STATS] = p->stats,
        [NEAR] = p->near,
        [NEAR_START] = p->near_start,
        [OUTER_MASKS] = p->outer.masks,
        [OUTER_START] = p->outer.start,
        [OUTER_RECORDS] = p->outer.records,
        [INNER_MASKS] = p->inner.masks,
        [INNER_START] = p->inner.start,
        [INNER_RECORDS] = p->inner.records,
        [THICKNESS] = p->thickness,
        [HIDDEN] = p->hidden,
        [SMOOTH] = p->smooth,
        [CELL_MASKS] = p->stored.masks,
        [CELL_START] = p->stored.cell_start,
        [CELLS] = p->stored.cells,
        [DISTANCES] = p->stored.distances,
        [HULL] = p->stored.hull,
        [OCCLUSION] = p->stored.occlusion,
        [OPACITY] = p->stored.opacity,
    };

    memcpy(out, sources, sizeof sources);
}

enum { COPIED_BYTES = 1 << 20 /* that a thread copies at a time */ };

/* A section that is being copied, which the threads share. */
typedef struct copying {
    const char *from;
    char *to;
} copying;

/* Copy the bytes [begin, end) of a section; an sc_range_fn on a copying. */
static void copy_bytes(void *user, size_t begin, size_t end, int thread)
{
    const copying *c = user;

    memcpy(c->to + begin, c->from + begin, end - begin);
}

/* Is this the section of an array of the team, which may be large? */
static bool is_of_team(int section)
{
    return section == IDS || (section >= NEAR && section <= THICKNESS);
}

/* Copy the header and those sections that every rank has for itself. */
static void pack_own(const block_header *h, const void *const sources[SECTIONS],
                     const uint64_t bytes[SECTIONS], void *block)
{
    memcpy(block, h, sizeof *h);
    for (int i = 0; i < SECTIONS; i++) {
        if (bytes[i] && !is_of_team(i))
            memcpy((char *)block + h->offset[i], sources[i], bytes[i]);
    }
}

void sc_preparation_pack(const sc_preparation *p, void *block)
{
    uint64_t bytes[SECTIONS];
    const block_header h = header_of(p, false, bytes);
    const void *sources[SECTIONS];

    sources_of(p, sources);
    pack_own(&h, sources, bytes, block);
    for (int i = 0; i < SECTIONS; i++) {
        copying c = {sources[i], (char *)block + h.offset[i]};

        if (is_of_team(i))
            sc_parallel_for(p->settings.threads, bytes[i], COPIED_BYTES, copy_bytes, &c);
    }
}

void sc_preparation_pack_together(const sc_preparation *p, void *block)
{
    uint64_t bytes[SECTIONS];
    const block_header h = header_of(p, false, bytes);
    const void *sources[SECTIONS];

    sources_of(p, sources);
    if (sc_team_is_first(p->team))
        pack_own(&h, sources, bytes, block);
    for (int i = 0; i < SECTIONS; i++) {
        copying c = {sources[i], (char *)block + h.offset[i]};

        if (is_of_team(i))
            sc_team_for(p->team, bytes[i], COPIED_BYTES, copy_bytes, &c);
    }
}

/* @return the checksum of a block. @param h its header, with 0 as checksum. @param bytes the
 * lengths of the sections. */
static uint64_t checksum_of(const block_header *h, const void *const sections[SECTIONS],
                            const uint64_t bytes[SECTIONS])
{
    uint64_t sum = sc_hash_bytes(h, sizeof *h, VERSION);

    for (int i = 0; i < SECTIONS; i++)
        sum = bytes[i] ? sc_hash_bytes(sections[i], bytes[i], sum) : sum;
    return sum;
}

/* Write a header or section at offset *at of the stream, then zeros up to offset @p end. *at is
 * moved on past all that has been written. @return false, without a message, if something could not
 * be. */
static bool put(FILE *stream, const void *data, uint64_t bytes, uint64_t *at, uint64_t end)
{
    static const char zeros[ALIGN_BYTES + SC_GATHER_BYTES];

    if (bytes && fwrite(data, 1, bytes, stream) != bytes)
        return false;
    *at += bytes;
    while (*at < end) {
        const uint64_t gap = end - *at < sizeof zeros ? end - *at : sizeof zeros;

        if (fwrite(zeros, 1, gap, stream) != gap)
            return false;
        *at += gap;
    }
    return true;
}

sc_status sc_preparation_save(const sc_ctx *ctx, const sc_preparation *p, const char *path,
                              bool replace, bool lasting)
{
    uint64_t bytes[SECTIONS], at = 0;
    block_header h = header_of(p, true, bytes);
    const void *sources[SECTIONS];
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};
    bool written;
    int error;

    sc_stage_begin(ctx, "writing", 0, h.total_bytes);
    sources_of(p, sources);
    h.checksum = checksum_of(&h, sources, bytes);
    SC_PASS(sc_outfile_open(ctx, path, replace, &file));
    file.fleeting = !lasting;
    written = put(file.stream, &h, sizeof h, &at, h.offset[IDS]);
    error = written ? 0 : errno;
    for (int i = 0; i < SECTIONS && written; i++) {
        const uint64_t before = at;

        written = put(file.stream, sources[i], bytes[i], &at,
                      i + 1 < SECTIONS ? h.offset[i + 1] : h.total_bytes);
        error = written ? 0 : errno;
        sc_stage_add(ctx, at - before);
    }
    if (!written)
        return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written after %llu of %llu bytes: %s",
                       path, (unsigned long long)at, (unsigned long long)h.total_bytes,
                       sc_reason(error));
    return sc_outfile_commit(ctx, &file);
}

bool sc_is_prepared_file(const char *path)
{
    char head[sizeof magic];
    struct stat info;
    FILE *stream;
    bool is_prepared;

    if (stat(path, &info) || !S_ISREG(info.st_mode)) /* opening a pipe would wait for its writer */
        return false;
    stream = fopen(path, "rb");
    if (!stream)
        return false;
    is_prepared =
        fread(head, 1, sizeof head, stream) == sizeof head && memcmp(head, magic, sizeof head) == 0;
    fclose(stream);
    return is_prepared;
}

/* The longest axis, and the most grid vertices, of a file that is read. */
enum { SIZE_MAX_VOXELS = INT32_MAX - 2 * SC_BRICK };
#define VERTICES_MAX 2199023255552.0

/* Are the sizes in a header possible, and do they agree with each other, with offset and with
 * total_bytes? */
static bool is_sound(const block_header *h)
{
    block_header again = *h;
    uint64_t bytes[SECTIONS];
    double vertices = 1;

    for (int i = 0; i < 3; i++) {
        if (h->size[i] < 1 || h->size[i] > SIZE_MAX_VOXELS ||
            h->bricks[i] != sc_bricks_along(h->size[i]))
            return false;
        vertices *= h->size[i] + 2;
    }
    /* At most 2^41 vertices: then no length of a section, and no sum of them, overflows. */
    if (vertices > VERTICES_MAX)
        return false;
    if ((double)h->near_count > vertices || (double)h->outer_count > vertices ||
        (double)h->inner_count > vertices || (double)h->stored.cell_count > vertices)
        return false;
    if ((h->near_count | h->outer_count | h->inner_count | h->stored.cell_count) > UINT32_MAX)
        return false;
    if ((h->label_bytes != 1 && h->label_bytes != 2) || h->label_count < 1 ||
        h->label_count > (h->label_bytes == 1 ? 256 : SC_LABELS_MAX))
        return false;
    if (h->stored.parts ? !(h->stored.parts & STORED_CELLS) ||
                              h->stored.parts > (STORED_CELLS | STORED_OCCLUSION)
                        : h->stored.cell_count || h->stored.hull_count)
        return false;
    /* Four points at most for either end of a row of voxels. */
    if (h->stored.hull_count > 8 * (uint64_t)h->size[1] * (uint64_t)h->size[2])
        return false;
    if ((h->oriented | h->local_thickness | h->resampled | h->as_drawn | h->numbered) & ~1)
        return false;
    lay_out(&again, bytes);
    return again.total_bytes == h->total_bytes &&
           memcmp(again.offset, h->offset, sizeof again.offset) == 0;
}

/* Check the header of a prepared file that is @p bytes long, and read it to @p h. @param path for
 * messages. @return SC_ERR_DATA. */
static sc_status check_header(const sc_ctx *ctx, const char *path, const void *block, size_t bytes,
                              block_header *h)
{
    if (bytes >= sizeof magic && memcmp(block, magic, sizeof magic) != 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: is no prepared file of segcast", path);
    memset(h, 0, sizeof *h);
    memcpy(h, block, bytes < sizeof *h ? bytes : sizeof *h);
    if (bytes >= sizeof(block_format) && h->format.byte_order != BYTE_ORDER_MARK)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: was prepared on a machine with another order of bytes; prepare it again here",
            path);
    if (bytes >= sizeof(block_format) &&
        (h->format.version != VERSION || h->format.header_bytes != sizeof *h))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is a prepared file of version %u, this segcast reads version %d; "
                       "prepare it again",
                       path, (unsigned)h->format.version, VERSION);
    if (bytes < sizeof *h)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has %zu bytes, fewer than the header of a prepared file: %zu; prepare it again",
            path, bytes, sizeof *h);
    if (!is_sound(h))
        return sc_fail(ctx, SC_ERR_DATA, "%s: the header is damaged; prepare it again", path);
    if (h->total_bytes != bytes)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has %zu bytes, expected %llu; prepare it again", path,
                       bytes, (unsigned long long)h->total_bytes);
    return SC_OK;
}

sc_status sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                size_t bytes, sc_prepared *out)
{
    block_header h;
    const void *sections[SECTIONS];
    uint64_t section_bytes[SECTIONS], checksum;
    sc_prepared view;

    SC_PASS(check_header(ctx, path, block, bytes, &h));
    checksum = h.checksum;
    h.checksum = 0;
    lay_out(&h, section_bytes);
    for (int i = 0; i < SECTIONS; i++)
        sections[i] = (const char *)block + h.offset[i];
    if (checksum_of(&h, sections, section_bytes) != checksum)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is damaged: its contents do not have the checksum it names; prepare it "
                       "again",
                       path);
    SC_PASS(sc_prepared_view(ctx, block, bytes, &view));
    SC_PASS(sc_check_prepared(ctx, path, &view));
    view.file_hash = checksum;
    *out = view;
    return SC_OK;
}

/* @return what a file holds of sc_stored. @param base the begin of the file. */
static sc_stored stored_in(const block_header *h, const char *base)
{
    sc_stored stored = {0};

    if (h->stored.parts & STORED_CELLS) {
        stored.masks = (const uint64_t *)(base + h->offset[CELL_MASKS]);
        stored.cell_start = (const uint32_t *)(base + h->offset[CELL_START]);
        stored.cells = (const sc_packed_cell *)(base + h->offset[CELLS]);
        stored.distances = (const uint8_t *)(base + h->offset[DISTANCES]);
        stored.hull = (const sc_vec3 *)(base + h->offset[HULL]);
        stored.cell_count = h->stored.cell_count;
        stored.hull_count = h->stored.hull_count;
    }
    if (h->stored.parts & STORED_OCCLUSION) {
        stored.occlusion = (const uint8_t(*)[2])(base + h->offset[OCCLUSION]);
        stored.opacity = (const float *)(base + h->offset[OPACITY]);
    }
    return stored;
}

sc_status sc_prepared_view(const sc_ctx *ctx, const void *block, size_t bytes, sc_prepared *out)
{
    const char *base = block;
    block_header h;
    sc_prepared view;

    if (bytes >= sizeof h)
        memcpy(&h, block, sizeof h);
    if (bytes < sizeof h || memcmp(h.format.magic, magic, sizeof magic) != 0 ||
        h.format.version != VERSION || h.format.header_bytes != sizeof h || h.total_bytes > bytes)
        return sc_fail(ctx, SC_ERR_DATA, "not a prepared volume of this version of segcast");
    view = (sc_prepared){
        .label_bytes = h.label_bytes,
        .label_count = h.label_count,
        .oriented = h.oriented != 0,
        .numbered = h.numbered != 0,
        .to_ras_mm = h.to_ras_mm,
        .volume_hash = h.volume_hash,
        .boundary.voxel_count = h.boundary_count,
        .ids = base + h.offset[IDS],
        .labels = (const sc_label *)(base + h.offset[LABELS]),
        .stats = (const sc_label_stats *)(base + h.offset[STATS]),
        .boundary.count = h.near_count,
        .boundary.masks = (const uint64_t *)(base + h.offset[NEAR]),
        .boundary.start = (const uint32_t *)(base + h.offset[NEAR_START]),
        .outer = {(const uint64_t *)(base + h.offset[OUTER_MASKS]),
                  (const uint32_t *)(base + h.offset[OUTER_START]),
                  (const uint32_t *)(base + h.offset[OUTER_RECORDS]), h.outer_count},
        .inner = {(const uint64_t *)(base + h.offset[INNER_MASKS]),
                  (const uint32_t *)(base + h.offset[INNER_START]),
                  (const uint32_t *)(base + h.offset[INNER_RECORDS]), h.inner_count},
        .how = {.resampled = h.resampled != 0,
                .as_drawn = h.as_drawn != 0,
                .hidden = (const uint8_t *)(base + h.offset[HIDDEN]),
                .smooth = (const sc_vec3 *)(base + h.offset[SMOOTH])},
        .stored = stored_in(&h, base),
    };
    if (h.local_thickness)
        view.thickness = (const uint8_t *)(base + h.offset[THICKNESS]);
    memcpy(view.size, h.size, sizeof view.size);
    memcpy(view.bricks, h.bricks, sizeof view.bricks);
    *out = view;
    return SC_OK;
}

sc_volume sc_volume_of_prepared(const sc_prepared *v)
{
    sc_volume out = {.label_bytes = v->label_bytes,
                     .ids = (void *)(uintptr_t)v->ids,
                     .label_count = v->label_count,
                     .labels = (sc_label *)(uintptr_t)v->labels,
                     .to_ras_mm = v->to_ras_mm,
                     .oriented = v->oriented,
                     .numbered = v->numbered};

    memcpy(out.size, v->size, sizeof out.size);
    return out;
}
