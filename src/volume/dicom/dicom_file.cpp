/* SPDX-License-Identifier: BSD-3-Clause */
/* The only file that includes DCMTK, and the only one in C++. */
#include "dicom/dicom_file.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcfcache.h>
#include <dcmtk/dcmdata/dcpixseq.h>
#include <dcmtk/dcmdata/dcpxitem.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dcspchrs.h>
#include <dcmtk/dcmdata/dctk.h>

#include <cstdio>
#include <cstring>
#include <new>

namespace
{

const Uint32 kept_bytes = 4096; /* larger values are left in the file */

} // namespace

struct sc_dicom {
    DcmFileFormat format;
    DcmSpecificCharacterSet characters;
    bool converts;      /* characters is of use */
    DcmElement *pixels; /* borrowed from format; NULL: none */
    DcmFileCache cache; /* of the file with the pixels */
};

namespace
{

DcmItem *item_of(const sc_dicom_item *item)
{
    return reinterpret_cast<DcmItem *>(const_cast<sc_dicom_item *>(item));
}

const sc_dicom_item *opaque(const DcmItem *item)
{
    return reinterpret_cast<const sc_dicom_item *>(item);
}

DcmTagKey key_of(uint32_t tag)
{
    return DcmTagKey(static_cast<Uint16>(tag >> 16), static_cast<Uint16>(tag & 0xffff));
}

/* @return the attribute @p tag of an item itself, not of one below it; NULL: none. */
DcmElement *find(const sc_dicom_item *item, uint32_t tag)
{
    DcmElement *element = nullptr;

    if (item_of(item)->findAndGetElement(key_of(tag), element).bad())
        return nullptr;
    return element;
}

/* Write value number @p i of an element to *out. @return whether it is a number. */
bool number_at(DcmElement *element, unsigned long i, double *out)
{
    Float64 real = 0;
    Float32 narrow = 0;
    Sint32 whole = 0;
    Sint16 small = 0;
    Uint32 natural = 0;
    Uint16 little = 0;

    switch (element->ident()) {
    case EVR_DS:
    case EVR_FD:
        return element->getFloat64(real, i).good() && (*out = real, true);
    case EVR_FL:
        return element->getFloat32(narrow, i).good() && (*out = narrow, true);
    case EVR_IS:
    case EVR_SL:
        return element->getSint32(whole, i).good() && (*out = whole, true);
    case EVR_SS:
        return element->getSint16(small, i).good() && (*out = small, true);
    case EVR_UL:
        return element->getUint32(natural, i).good() && (*out = natural, true);
    case EVR_US:
        return element->getUint16(little, i).good() && (*out = little, true);
    default:
        return false;
    }
}

/* DCMTK can unpack RLE as long as this lives. DCMTK itself does not free what it has registered. */
struct RleDecoder {
    RleDecoder()
    {
        DcmRLEDecoderRegistration::registerCodecs();
    }
    ~RleDecoder()
    {
        DcmRLEDecoderRegistration::cleanup();
    }
};

/* DCMTK keeps quiet, and can unpack RLE until the program ends. */
void prepare_library()
{
    static const RleDecoder rle_decoder;

    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
}

sc_dicom_result result_of(const OFCondition &condition)
{
    if (condition.good())
        return SC_DICOM_OK;
    return condition == EC_MemoryExhausted ? SC_DICOM_MEMORY : SC_DICOM_BAD;
}

} // namespace

sc_dicom_result sc_dicom_open(const char *path, char why[SC_DICOM_WHY_BYTES], sc_dicom **out)
try {
    prepare_library();

    sc_dicom *file = new sc_dicom();
    OFCondition condition =
        file->format.loadFile(path, EXS_Unknown, EGL_noChange, kept_bytes, ERM_fileOnly);
    DcmDataset *data = file->format.getDataset();
    OFString set;

    if (condition.bad()) {
        snprintf(why, SC_DICOM_WHY_BYTES, "%s", condition.text());
        delete file;
        return result_of(condition);
    }
    if (data->findAndGetElement(DCM_PixelData, file->pixels).bad())
        file->pixels = nullptr;
    if (data->findAndGetOFStringArray(DCM_SpecificCharacterSet, set).good() && !set.empty())
        file->converts = file->characters.selectCharacterSet(set).good();
    *out = file;
    return SC_DICOM_OK;
} catch (...) { /* what DCMTK throws is std::bad_alloc */
    return SC_DICOM_MEMORY;
}

void sc_dicom_close(sc_dicom *file)
{
    delete file;
}

const sc_dicom_item *sc_dicom_root(const sc_dicom *file)
{
    return opaque(const_cast<sc_dicom *>(file)->format.getDataset());
}

const sc_dicom_item *sc_dicom_next(const sc_dicom_item *item, uint32_t tag,
                                   const sc_dicom_item *previous)
try {
    DcmSequenceOfItems *sequence = dynamic_cast<DcmSequenceOfItems *>(find(item, tag));

    /* not by number, which takes as many steps */
    return sequence ? opaque(dynamic_cast<DcmItem *>(sequence->nextInContainer(item_of(previous))))
                    : nullptr;
} catch (...) {
    return nullptr;
}

size_t sc_dicom_numbers(const sc_dicom_item *item, uint32_t tag, double *out, size_t most)
try {
    DcmElement *element = find(item, tag);
    const size_t count = element ? element->getVM() : 0;

    for (size_t i = 0; i < count && i < most; i++) {
        if (!number_at(element, i, &out[i]))
            return 0;
    }
    return count > most ? most + 1 : count;
} catch (...) {
    return 0;
}

void sc_dicom_text(const sc_dicom *file, const sc_dicom_item *item, uint32_t tag, char *out,
                   size_t size)
try {
    DcmElement *element = find(item, tag);
    OFString text, converted;

    out[0] = '\0';
    if (!element || !element->isaString() || element->getOFString(text, 0).bad())
        return;
    if (file->converts &&
        const_cast<sc_dicom *>(file)->characters.convertString(text, converted, "\\").good())
        text = converted;
    snprintf(out, size, "%s", text.c_str());
} catch (...) {
    out[0] = '\0';
}

uint64_t sc_dicom_pixel_bytes(const sc_dicom *file)
{
    return file->pixels ? file->pixels->getLengthField() : 0;
}

sc_dicom_result sc_dicom_read_bytes(sc_dicom *file, uint64_t offset, size_t bytes, void *out)
try {
    if (!file->pixels || offset + bytes > UINT32_MAX)
        return SC_DICOM_BAD;
    return result_of(file->pixels->getPartialValue(out, static_cast<Uint32>(offset),
                                                   static_cast<Uint32>(bytes), &file->cache,
                                                   EBO_LittleEndian));
} catch (...) {
    return SC_DICOM_MEMORY;
}

/* Are the offsets in the header of a frame that is compressed by RLE (PS3.5, G.5) within it? DCMTK
 * reads wherever they lead. The standard wants one fragment for each frame, behind a table. */
static bool is_sane_frame(DcmPixelData *pixels, DcmDataset *dataset, uint32_t frame)
{
    enum { HEADER_BYTES = 64, SEGMENTS_MAX = 15 };
    DcmPixelSequence *fragments = nullptr;
    DcmPixelItem *item = nullptr;
    Sint32 frames = 1;
    Uint8 *data = nullptr;
    uint32_t before = HEADER_BYTES, count = 0, bytes;

    dataset->findAndGetSint32(DCM_NumberOfFrames, frames);
    if (pixels->getEncapsulatedRepresentation(EXS_RLELossless, nullptr, fragments).bad() ||
        !fragments || frames < 1 || frame >= static_cast<uint32_t>(frames) ||
        fragments->card() != static_cast<unsigned long>(frames) + 1 ||
        fragments->getItem(item, frame + 1).bad() || !item || item->getUint8Array(data).bad() ||
        !data || item->getLength() < HEADER_BYTES)
        return false;
    bytes = item->getLength();
    for (uint32_t i = 0; i <= SEGMENTS_MAX && i <= count; i++) {
        const uint32_t number = data[4 * i] | data[4 * i + 1] << 8 | data[4 * i + 2] << 16 |
                                static_cast<uint32_t>(data[4 * i + 3]) << 24;

        if (i == 0)
            count = number;
        if (i == 0 ? number < 1 || number > SEGMENTS_MAX : number < before || number > bytes)
            return false;
        before = i == 0 ? before : number;
    }
    return true;
}

sc_dicom_result sc_dicom_read_frame(sc_dicom *file, uint32_t frame, size_t bytes, void *out)
try {
    DcmPixelData *pixels = dynamic_cast<DcmPixelData *>(file->pixels);
    Uint32 fragment = 0;
    OFString colors;

    if (!pixels || bytes >= UINT32_MAX || !is_sane_frame(pixels, file->format.getDataset(), frame))
        return SC_DICOM_BAD;
    return result_of(pixels->getUncompressedFrame(file->format.getDataset(), frame, fragment, out,
                                                  static_cast<Uint32>(bytes + bytes % 2), colors,
                                                  &file->cache));
} catch (...) {
    return SC_DICOM_MEMORY;
}
