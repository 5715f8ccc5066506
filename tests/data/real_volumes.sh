# SPDX-License-Identifier: BSD-3-Clause
# Real label volumes are read, with as many labels and the axes that their sources name.
[ -d "$DATA/real" ] || skip "there is no $DATA/real (SC_TEST_DATA)"
expect_labels() { # expect_labels FILE COUNT AXES: labels without background, orientation
    "$SEGCAST" info "$DATA/$1" --json >info.json 2>stderr.txt || { cat stderr.txt; fail "$1 cannot be read"; }
    jq -e "(.labels | length) - 1 == $2 and .axes == \"$3\"" info.json >/dev/null ||
        fail "$1: $(jq -c '[(.labels | length) - 1, .axes]' info.json), expected $2 $3"
}
# expect_kept FILE COUNT AXES LABEL: as expect_labels, of a large volume: only one tissue is measured, in a tenth of the time.
expect_kept() {
    "$SEGCAST" info "$DATA/$1" --json --set "volume.keep=[$4]" >info.json 2>stderr.txt || { cat stderr.txt; fail "$1 cannot be read"; }
    grep -q "volume.keep: 1 of $2 tissues are kept" stderr.txt || { cat stderr.txt; fail "$1: expected $2 labels"; }
    jq -e "(.labels | length) == 2 and .labels[1].value == $4 and .axes == \"$3\"" info.json >/dev/null || fail "$1: $(jq -c .axes info.json), expected $3"
}
expect_kept heart_469x325x487.nrrd 17 LPS 1
jq -e '.labels[1].name == "myocardium" and .labels[1].color == [200,80,70]' info.json >/dev/null || fail "name or colour of label 1 of the heart"
expect_kept real/totalseg_s0327/s0327_all_1p5mm.nrrd 114 RAS 1
expect_kept real/spl_brain/hncma-atlas.nrrd 312 PIL 11
expect_kept real/papaya_talairach/Talairach_labels_1mm.nii.gz 659 LAS 1
expect_kept real/inia19_macaque/inia19-NeuroMaps.nii.gz 724 RAS 1
expect_kept real/vtk_frog/frogtissue.mhd 25 LPS 1
expect_labels real/pynrrd_samples/BallBinary30x30x30_bz2.nrrd 1 LPS
expect_labels real/slicerio/SegmentationOverlapping.seg.nrrd 8 RAS
jq -e '.labels[8].name == "overlapping sphere" and .labels[8].voxels == 18648' info.json >/dev/null || fail "the sphere of the second layer is not whole"
jq -e '.labels[1].name == "ribs" and .labels[1].color == [253, 232, 158]' info.json >/dev/null || fail "name or colour of the ribs of 3D Slicer"
grep -q '15514 voxels belong to several segments' stderr.txt || fail "the overlap of the layers is not told"

expect_labels real/slicerio/Segmentation.seg.nrrd 7 RAS
expect_labels real/dcmqi/liver_spine_seg.nrrd 2 LPS
expect_labels real/dcmqi/partial_overlaps-1.nrrd 3 LPS
for file in .nhdr .nii.gz .nrrd _byteskip_minus_one.nhdr _byteskip_minus_one_nifti.nhdr _gz.nrrd _gz_byteskip_minus_one.nrrd _gz_lineskip.nrrd; do
    expect_labels real/pynrrd_samples/BallBinary30x30x30$file 1 LPS
    jq -e '.labels[1].voxels == 14328' info.json >/dev/null || fail "$file: the ball is not whole"
done

expect_labels real/totalseg_s0327/masks 108 RAS
expect_kept real/niivue/aparc.a2009s+aseg.mgz 188 LIA 17
jq -e '.labels[] | select(.name == "Left-Hippocampus") | .value == 17 and .color == [220, 216, 20]' info.json >/dev/null ||
    fail "the colour table of FreeSurfer's own file is not used: $(jq -c '.labels[1]' info.json)"
expect_kept real/totalsegmentator/example_seg.nii.gz 41 RAS 5
"$SEGCAST" info "$DATA/real/totalsegmentator/example_seg.nii.gz" 2>&1 | grep -q 'built without Expat' ||
    jq -e '.labels[] | select(.name == "liver") | .value == 5 and .color == [0, 255, 255]' info.json >/dev/null ||
    fail "the liver of TotalSegmentator has not the name or colour of its file: $(jq -c '.labels[5]' info.json)"

# Label tables of other programs: each is recognised, and its rows, as number, name and colour, are those of its program.
colors() { # colors TABLE KIND ROW...
    "$SEGCAST" convert "$DATA/real/$1" -o - --to bids >stdout.txt 2>stderr.txt || fail "$1 cannot be read"
    grep -q "read as a.* $2 label table" stderr.txt || { cat stderr.txt; fail "$1 was not recognised as a $2 table"; }
    printf '%b\n' "${@:3}" | while read -r row; do grep -qx "$row" stdout.txt || fail "$1: expected $row"; done
}
colors spl_brain/hncma-atlas-lut.ctbl Slicer '2\twhite matter of left cerebral hemisphere\t#fafae1'
colors label_tables/slicer/GenericAnatomyColors.txt Slicer '1\ttissue\t#80ae80' '3\tskin\t#b17a65'
colors label_tables/slicer/AbdomenColors.txt Slicer '3\tliver\t#933b00'
colors label_tables/slicerheart/HeartValves.ctbl Slicer '1\tmitral anterior leaflet\t#ff1208'
colors label_tables/FreeSurferColorLUT.txt FreeSurfer '17\tLeft-Hippocampus\t#dcd814'
colors allen_human/itksnap_label_description_Br.txt ITK-SNAP '4\tFI - 10329\t#c1a68f'
colors allen_human/AllenAtlas.json JSON '11\tGPe\t#d7e0bf'
colors niivue/aal.json JSON '5\tFrontal_Sup_Orb_L\t#c359cc'
colors spl_brain/hncma-atlas-lut.tsv 'CSV or TSV' '11\tleft caudate nucleus\t#1e6f55'
colors label_tables/FastSurfer_ColorLUT.tsv 'CSV or TSV' '17\tLeft-Hippocampus\t#dcd814'
