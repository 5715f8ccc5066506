/* SPDX-License-Identifier: BSD-3-Clause */
/* Meshes as 3MF, for printing: a ZIP archive of three XML files, the model among them, in mm. Its
 * times are those of no day, so that the same mesh is the same bytes. */
#include "internal.h"

#include <zlib.h>

enum {
    PARTS = 3, /* of the archive */
    BUFFER_BYTES = 1 << 16,
    LOCAL_SIGNATURE = 0x04034b50,
    CENTRAL_SIGNATURE = 0x02014b50,
    END_SIGNATURE = 0x06054b50,
    ZIP_VERSION = 20, /* deflated files */
    METHOD_DEFLATED = 8,
    FIRST_OF_JANUARY_1980 = 0x21,
    SIZES_AT = 14, /* where check sum and sizes stand in a local header */
    LEVEL = 3      /* of compression: beyond, a tenth less for twice the time */
};

/* One file of the archive. */
typedef struct part {
    const char *name;
    long at; /* where its header begins */
    uint32_t crc;
    uint64_t bytes, packed_bytes;
} part;

/* An archive that is written. */
typedef struct archive {
    FILE *stream;
    z_stream z;
    part *now; /* that is being written */
    size_t used;
    char text[BUFFER_BYTES]; /* that is still to be packed */
    uint8_t packed[BUFFER_BYTES];
} archive;

static void put_u16(FILE *stream, unsigned value)
{
    fputc((int)(value & 255), stream);
    fputc((int)(value >> 8 & 255), stream);
}

/* Pack the text so far. */
static void flush_text(archive *a, int how)
{
    part *p = a->now;

    a->z.next_in = (uint8_t *)a->text;
    a->z.avail_in = (unsigned)a->used;
    p->crc = (uint32_t)crc32(p->crc, (const uint8_t *)a->text, (unsigned)a->used);
    p->bytes += a->used;
    a->used = 0;
    do {
        size_t count;

        a->z.next_out = a->packed;
        a->z.avail_out = sizeof a->packed;
        (void)deflate(&a->z, how);
        count = sizeof a->packed - a->z.avail_out;
        fwrite(a->packed, 1, count, a->stream);
        p->packed_bytes += count;
    } while (a->z.avail_out == 0);
}

/* Add formatted text of less than 256 bytes to the part. */
SC_PRINTF(2, 3) static void put(archive *a, const char *format, ...)
{
    va_list arguments;

    if (sizeof a->text - a->used < 256)
        flush_text(a, Z_NO_FLUSH);
    va_start(arguments, format);
    a->used += (size_t)vsnprintf(a->text + a->used, 256, format, arguments);
    va_end(arguments);
}

/* Write what the local and the central header of a part have in common. */
static void put_facts(FILE *stream, const part *p)
{
    put_u16(stream, ZIP_VERSION);
    put_u16(stream, 0);
    put_u16(stream, METHOD_DEFLATED);
    put_u16(stream, 0);
    put_u16(stream, FIRST_OF_JANUARY_1980);
    sc_put_u32(stream, p->crc);
    sc_put_u32(stream, (uint32_t)p->packed_bytes);
    sc_put_u32(stream, (uint32_t)p->bytes);
    put_u16(stream, (unsigned)strlen(p->name));
    put_u16(stream, 0);
}

/* Begin a part, whose header is completed at its end. */
static void begin_part(archive *a, part *p)
{
    a->now = p;
    p->at = ftell(a->stream);
    sc_put_u32(a->stream, LOCAL_SIGNATURE);
    put_facts(a->stream, p);
    fputs(p->name, a->stream);
    (void)deflateReset(&a->z);
}

static void end_part(archive *a)
{
    flush_text(a, Z_FINISH);
    fseek(a->stream, a->now->at + 4, SEEK_SET);
    put_facts(a->stream, a->now);
    fseek(a->stream, 0, SEEK_END);
}

/* Write the list of the parts at the end of the archive. */
static void put_directory(FILE *stream, const part *parts)
{
    const long begin = ftell(stream);
    long end;

    for (int i = 0; i < PARTS; i++) {
        sc_put_u32(stream, CENTRAL_SIGNATURE);
        put_u16(stream, ZIP_VERSION);
        put_facts(stream, &parts[i]);
        for (int k = 0; k < 3; k++)
            put_u16(stream, 0);
        sc_put_u32(stream, 0);
        sc_put_u32(stream, (uint32_t)parts[i].at);
        fputs(parts[i].name, stream);
    }
    end = ftell(stream);
    sc_put_u32(stream, END_SIGNATURE);
    sc_put_u32(stream, 0);
    put_u16(stream, PARTS);
    put_u16(stream, PARTS);
    sc_put_u32(stream, (uint32_t)(end - begin));
    sc_put_u32(stream, (uint32_t)begin);
    put_u16(stream, 0);
}

/* Add a name as the value of an attribute. Control characters, which XML has not, become spaces. */
static void put_name(archive *a, const char *name)
{
    for (; *name; name++) {
        const char *escaped = *name == '&'   ? "&amp;"
                              : *name == '<' ? "&lt;"
                              : *name == '"' ? "&quot;"
                                             : NULL;

        if (escaped)
            put(a, "%s", escaped);
        else
            put(a, "%c", (unsigned char)*name < ' ' ? ' ' : *name);
    }
}

/* Add the surface of one tissue as an object. */
static void put_body(archive *a, const sc_mesh_file *f, int id, int number)
{
    const sc_mesh *mesh = f->bodies->mesh;
    sc_body body;

    sc_bodies_get(f->bodies, id, &body);
    put(a, "<object id=\"%d\" type=\"model\" pid=\"1\" pindex=\"%d\" name=\"", number + 2, number);
    put_name(a, f->tissues[id].name);
    put(a, "\"><mesh><vertices>\n");
    for (size_t i = 0; i < body.vertex_count; i++) {
        const float *v = mesh->vertices[body.vertices[i]];

        put(a, "<vertex x=\"%.9g\" y=\"%.9g\" z=\"%.9g\"/>\n", (double)v[0], (double)v[1],
            (double)v[2]);
    }
    put(a, "</vertices><triangles>\n");
    for (size_t i = 0; i < body.triangle_count; i++)
        put(a, "<triangle v1=\"%u\" v2=\"%u\" v3=\"%u\"/>\n", body.triangles[i][0],
            body.triangles[i][1], body.triangles[i][2]);
    put(a, "</triangles></mesh></object>\n");
}

/* Add the model: the colours as materials, an object for each tissue, and all of them to be built.
 */
static void put_model(archive *a, const sc_mesh_file *f)
{
    int count = 0;

    put(a, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" "
           "xml:lang=\"en-US\" "
           "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n");
    put(a, "<metadata name=\"Application\">segcast</metadata>\n");
    put(a, "<resources><basematerials id=\"1\">\n");
    for (int id = 1; id < f->label_count; id++) {
        const sc_mesh_tissue *tissue = &f->tissues[id];

        if (!tissue->wanted)
            continue;
        put(a, "<base name=\"");
        put_name(a, tissue->name);
        put(a, "\" displaycolor=\"#%02X%02X%02XFF\"/>\n", tissue->rgb[0], tissue->rgb[1],
            tissue->rgb[2]);
    }
    put(a, "</basematerials>\n");
    for (int id = 1; id < f->label_count; id++) {
        if (f->tissues[id].wanted)
            put_body(a, f, id, count++);
    }
    put(a, "</resources><build>\n");
    for (int i = 0; i < count; i++)
        put(a, "<item objectid=\"%d\"/>\n", i + 2);
    put(a, "</build></model>\n");
}

sc_status sc_write_3mf(const sc_ctx *ctx, const sc_mesh_file *f)
{
    part parts[PARTS] = {
        {.name = "[Content_Types].xml"}, {.name = "_rels/.rels"}, {.name = "3D/3dmodel.model"}};
    SC_OWN(sc_free_at) archive *a = NULL;
    long end;

    SC_PASS(SC_ZALLOC(ctx, 1, &a));
    a->stream = f->stream;
    if (deflateInit2(&a->z, LEVEL, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: no memory to compress it", f->path);
    begin_part(a, &parts[0]);
    put(a, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Types "
           "xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n");
    put(a, "<Default Extension=\"rels\" "
           "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n");
    put(a, "<Default Extension=\"model\" "
           "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n");
    end_part(a);
    begin_part(a, &parts[1]);
    put(a, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships "
           "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n");
    put(a, "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
           "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
           "</Relationships>\n");
    end_part(a);
    begin_part(a, &parts[2]);
    put_model(a, f);
    end_part(a);
    (void)deflateEnd(&a->z);
    put_directory(f->stream, parts);
    end = ftell(f->stream);
    if (parts[2].bytes > UINT32_MAX || end > (long)UINT32_MAX)
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "%s: the model takes %s, and a file of a ZIP archive has 4 GiB at most; "
                       "choose fewer tissues (--tissue), or write .ply",
                       f->path, sc_size_text((double)parts[2].bytes, (char[24]){0}));
    return SC_OK;
}
