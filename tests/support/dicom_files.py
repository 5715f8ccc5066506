# SPDX-License-Identifier: BSD-3-Clause
"""Writes small DICOM segmentations with pydicom, and the same volumes as NRRD, for tests."""
import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.pixel_data_handlers.rle_handler import rle_encode_frame
from pydicom.sequence import Sequence

SEGMENTATION, LABEL_MAP = '1.2.840.10008.5.1.4.1.1.66.4', '1.2.840.10008.5.1.4.1.1.66.7'
SYNTAXES = dict(implicit='1.2.840.10008.1.2', explicit='1.2.840.10008.1.2.1', big='1.2.840.10008.1.2.2',
                deflated='1.2.840.10008.1.2.1.99', rle='1.2.840.10008.1.2.5')
ORIGIN, ALONG_X = (-10., 20., 30.), (1., 0, 0, 0, 1, 0)

LABELS = np.zeros((7, 23, 19), np.uint8)  # z, y, x
LABELS[1:5, 3:15, 2:9] = 1
LABELS[2:6, 8:20, 9:17] = 2
LABELS[3, 21, 4] = 200


def lab_of(rgb):
    """The CIELab value of an sRGB colour as DICOM stores it: white D50, by Bradford's adaptation."""
    linear = [c / 12.92 if c <= .04045 else ((c + .055) / 1.055) ** 2.4 for c in np.array(rgb) / 255]
    xyz = np.array([[.4124564, .3575761, .1804375], [.2126729, .7151522, .072175], [.0193339, .119192, .9503041]]) @ linear
    cone = np.array([[.8951, .2664, -.1614], [-.7502, 1.7135, .0367], [.0389, -.0685, 1.0296]])
    d65, d50 = np.array([.95047, 1, 1.08883]), np.array([.96422, 1, .82521])
    xyz = np.linalg.inv(cone) @ np.diag((cone @ d50) / (cone @ d65)) @ cone @ xyz / d50
    x, y, z = [t ** (1 / 3) if t > (6 / 29) ** 3 else t * (29 / 6) ** 2 / 3 + 4 / 29 for t in xyz]
    return [round(v) for v in ((116 * y - 16) * 655.35, (500 * (x - y) + 128) * 257, (200 * (y - z) + 128) * 257)]


def code(meaning, modifier=None):
    item = Dataset()
    item.CodeValue, item.CodingSchemeDesignator, item.CodeMeaning = '1234', 'SCT', meaning
    if modifier:
        item.SegmentedPropertyTypeModifierCodeSequence = Sequence([code(modifier)])
    return item


# number, label, colour, meaning of the code, modifier
SEGMENTS = [(1, 'Myocardium é', (200, 120, 60), 'Myocardium', None), (2, '\x1b[31mred', (255, 0, 0), 'Tissue', None),
            (200, 'Segment_3', None, 'Kidney', 'Right')]


def frames_of(labels):
    """A frame for each label of each slice that has it, in no order."""
    frames = [(int(s), z, labels[z] == s) for z in range(len(labels)) for s in np.unique(labels[z]) if s]
    return [frames[i] for i in np.random.default_rng(1).permutation(len(frames))]


def slices_of(labels):
    """A frame for each slice with labels, from the last to the first."""
    return [(None, z, labels[z]) for z in reversed(range(len(labels))) if labels[z].any()]


def segment_item(number, label, color, meaning, modifier):
    item = Dataset()
    item.SegmentNumber, item.SegmentLabel, item.SegmentAlgorithmType = number, label, 'MANUAL'
    item.SegmentedPropertyCategoryCodeSequence = Sequence([code('Anatomical Structure')])
    item.SegmentedPropertyTypeCodeSequence = Sequence([code(meaning, modifier)])
    if color:
        item.RecommendedDisplayCIELabValue = lab_of(color)
    return item


def place_frames(data, frames, spacing, thickness, orientation):
    measures, plane, shared = Dataset(), Dataset(), Dataset()
    measures.PixelSpacing, measures.SliceThickness, measures.SpacingBetweenSlices = list(spacing), thickness, thickness
    plane.ImageOrientationPatient = list(orientation)
    shared.PixelMeasuresSequence, shared.PlaneOrientationSequence = Sequence([measures]), Sequence([plane])
    data.SharedFunctionalGroupsSequence = Sequence([shared])
    normal = np.cross(orientation[:3], orientation[3:])
    data.PerFrameFunctionalGroupsSequence = Sequence()
    for segment, z, _ in frames:
        frame, position, identity = Dataset(), Dataset(), Dataset()
        position.ImagePositionPatient = [round(float(v), 6) for v in np.array(ORIGIN) + normal * thickness * z]
        frame.PlanePositionSequence = Sequence([position])
        if segment is not None:
            identity.ReferencedSegmentNumber = segment
            frame.SegmentIdentificationSequence = Sequence([identity])
        data.PerFrameFunctionalGroupsSequence.append(frame)


def name_images(data, frames, images, by_frame=True):
    """Name the images, of which images[z] is that of slice z, and by_frame that of each frame."""
    instance = Dataset()
    instance.ReferencedInstanceSequence = Sequence()
    for image in sorted(set(images)):
        reference = Dataset()
        reference.ReferencedSOPClassUID, reference.ReferencedSOPInstanceUID = '1.2.840.10008.5.1.4.1.1.2', f'1.2.3.{image}'
        instance.ReferencedInstanceSequence.append(reference)
    instance.SeriesInstanceUID = '1.2.3'
    data.ReferencedSeriesSequence = Sequence([instance])
    for (_, z, _), groups in zip(frames, data.PerFrameFunctionalGroupsSequence if by_frame else ()):
        derivation, source = Dataset(), Dataset()
        source.ReferencedSOPClassUID, source.ReferencedSOPInstanceUID = '1.2.840.10008.5.1.4.1.1.2', f'1.2.3.{images[z]}'
        derivation.SourceImageSequence = Sequence([source])
        groups.DerivationImageSequence = Sequence([derivation])


def set_pixels(data, frames, kind, syntax):
    pixels = np.stack([a for _, _, a in frames])
    bits = 1 if kind == 'BINARY' else 8 * pixels.dtype.itemsize
    data.BitsAllocated = data.BitsStored = bits
    data.HighBit = bits - 1
    if kind == 'BINARY':
        raw = np.packbits(pixels.ravel().astype(bool), bitorder='little').tobytes()
    else:
        raw = pixels.astype(pixels.dtype.newbyteorder('>' if syntax == SYNTAXES['big'] else '<')).tobytes()
    data.PixelData = raw + b'\0' * (len(raw) % 2)
    data['PixelData'].VR = 'OW' if bits == 16 or syntax == SYNTAXES['implicit'] else 'OB'
    if syntax == SYNTAXES['rle']:
        data.PixelData = encapsulate([rle_encode_frame(a) for a in pixels])
        data['PixelData'].VR = 'OB'
        data['PixelData'].is_undefined_length = True


def write(name, frames, segments, kind='BINARY', syntax=SYNTAXES['explicit'], characters='ISO_IR 192', spacing=(.75, .5),
          thickness=1.25, orientation=ALONG_X, change=None):
    """Write frames (segment or None, slice, pixels) to the file @p name; change(data) may spoil it before."""
    data, meta = Dataset(), FileMetaDataset()
    meta.MediaStorageSOPClassUID = data.SOPClassUID = LABEL_MAP if kind == 'LABELMAP' else SEGMENTATION
    meta.MediaStorageSOPInstanceUID = data.SOPInstanceUID = meta.ImplementationClassUID = '1.2.3'
    meta.TransferSyntaxUID = syntax
    data.file_meta, data.preamble = meta, bytes(128)
    data.SpecificCharacterSet, data.Modality = characters, 'SEG'
    data.PatientName, data.PatientID = 'Secret^Name', 'SECRET-ID'
    data.SamplesPerPixel, data.PhotometricInterpretation, data.PixelRepresentation = 1, 'MONOCHROME2', 0
    data.NumberOfFrames, (data.Rows, data.Columns) = len(frames), frames[0][2].shape
    data.SegmentationType = kind
    if kind == 'FRACTIONAL':
        data.SegmentationFractionalType, data.MaximumFractionalValue = 'PROBABILITY', 200
    data.SegmentSequence = Sequence([segment_item(*s) for s in segments])
    place_frames(data, frames, spacing, thickness, orientation)
    set_pixels(data, frames, kind, syntax)
    if change:
        change(data)
    data.is_little_endian, data.is_implicit_VR = syntax != SYNTAXES['big'], syntax == SYNTAXES['implicit']
    pydicom.dcmwrite(name, data, write_like_original=False)


def write_nrrd(name, labels, orientation=ALONG_X, spacing=(.75, .5), thickness=1.25, before=0, behind=0):
    """The same volume in the slices that have labels, and in some without before and behind these."""
    used = [z for z in range(len(labels)) if labels[z].any()]
    labels = labels[used[0] - before:used[-1] + 1 + behind]
    axes = [np.array(orientation[:3]) * spacing[1], np.array(orientation[3:]) * spacing[0],
            np.cross(orientation[:3], orientation[3:]) * thickness]
    vector = lambda v: '(' + ','.join(repr(round(float(c), 12)) for c in v) + ')'
    header = ['NRRD0004', 'type: uint8', 'dimension: 3', 'sizes: ' + ' '.join(map(str, labels.shape[::-1])),
              'space: left-posterior-superior', 'space directions: ' + ' '.join(map(vector, axes)),
              'space origin: ' + vector(np.array(ORIGIN) + axes[2] * (used[0] - before)), 'encoding: raw']
    for i, (number, label, color, *_) in enumerate(SEGMENTS):
        header += [f'Segment{i}_LabelValue:={number}', f'Segment{i}_Name:={label if number != 200 else "Kidney, Right"}']
        if color:
            header += [f'Segment{i}_Color:=' + ' '.join(str(c / 255) for c in color)]
    with open(name, 'wb') as out:
        out.write(('\n'.join(header) + '\n\n').encode() + labels.tobytes())
