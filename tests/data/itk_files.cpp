/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes a label volume through ITK, as programs that are built on it do.
 * usage: itk_files VOXELS NX NY NZ SX SY SZ OX OY OZ OUT...
 * VOXELS is a file of bytes, x fastest, on axes that lead to the patient's right, front and head,
 * with their spacing and the place of the first voxel in mm. The endings of OUT name the formats. A
 * name that holds "turned" gets the same object on other axes: the first voxel is the last one, and
 * the axes lead along z, x and y. Those that hold "packed" are compressed. */
#include <itkHDF5ImageIO.h>
#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

typedef itk::Image<unsigned char, 3> Labels;

/* The volume on axes of which axis i is axis order[i] of the file, backwards where it is flipped.
 * ITK's coordinates lead to the patient's left, back and head. */
static Labels::Pointer make_image(const std::vector<char> &voxels, const int size[3],
                                  const double spacing[3], const double origin[3],
                                  const int order[3], bool is_flipped)
{
    static const double to_lps[3] = {-1, -1, 1};
    Labels::Pointer image = Labels::New();
    Labels::SizeType sizes;
    Labels::SpacingType spacings;
    Labels::PointType place;
    Labels::DirectionType direction;

    direction.Fill(0);
    for (int i = 0; i < 3; i++) {
        const int axis = order[i];
        const double first_mm = is_flipped ? spacing[axis] * (size[axis] - 1) : 0;

        sizes[i] = (unsigned long)size[axis];
        spacings[i] = spacing[axis];
        direction[axis][i] = to_lps[axis] * (is_flipped ? -1 : 1);
        place[axis] = to_lps[axis] * (origin[axis] + first_mm);
    }
    image->SetRegions(Labels::RegionType(sizes));
    image->SetSpacing(spacings);
    image->SetOrigin(place);
    image->SetDirection(direction);
    image->Allocate();
    for (size_t n = 0; n < voxels.size(); n++) {
        const int at[3] = {(int)(n % size[0]), (int)(n / size[0] % size[1]),
                           (int)(n / size[0] / size[1])};
        Labels::IndexType index;

        for (int i = 0; i < 3; i++)
            index[i] = is_flipped ? size[order[i]] - 1 - at[order[i]] : at[order[i]];
        image->SetPixel(index, (unsigned char)voxels[n]);
    }
    return image;
}

/* The part of ITK that writes files of this ending. */
static itk::ImageIOBase::Pointer io_for(const std::string &name)
{
    const std::string ending = name.substr(name.find('.'));

    if (ending == ".nrrd" || ending == ".nhdr")
        return itk::NrrdImageIO::New().GetPointer();
    if (ending == ".mha" || ending == ".mhd")
        return itk::MetaImageIO::New().GetPointer();
    if (ending == ".h5")
        return itk::HDF5ImageIO::New().GetPointer();
    return itk::NiftiImageIO::New().GetPointer();
}

int main(int argc, char **argv)
{
    const int as_they_are[3] = {0, 1, 2}, turned[3] = {2, 0, 1};
    int size[3];
    double spacing[3], origin[3];

    if (argc < 12)
        return 64;
    std::ifstream file(argv[1], std::ios::binary);
    const std::vector<char> voxels{std::istreambuf_iterator<char>(file),
                                   std::istreambuf_iterator<char>()};

    for (int i = 0; i < 3; i++) {
        size[i] = std::atoi(argv[2 + i]);
        spacing[i] = std::atof(argv[5 + i]);
        origin[i] = std::atof(argv[8 + i]);
    }
    if (voxels.size() != (size_t)size[0] * (size_t)size[1] * (size_t)size[2])
        return 65;
    for (int i = 11; i < argc; i++) {
        const std::string name = argv[i];
        const bool is_turned = name.find("turned") != std::string::npos;
        itk::ImageFileWriter<Labels>::Pointer writer = itk::ImageFileWriter<Labels>::New();

        try {
            writer->SetInput(make_image(voxels, size, spacing, origin,
                                        is_turned ? turned : as_they_are, is_turned));
            writer->SetImageIO(io_for(name));
            writer->SetFileName(name);
            writer->SetUseCompression(name.find("packed") != std::string::npos);
            writer->Update();
        } catch (const itk::ExceptionObject &error) {
            std::cerr << name << ": " << error.GetDescription() << "\n";
            return 74;
        }
    }
    return 0;
}
