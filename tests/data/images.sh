# SPDX-License-Identifier: BSD-3-Clause
# One MR image, stored in several orders of its axes with a matrix each, is seen at the same place behind the labels of a
# brain: pictures differ at most by the rounding of positions. A value scaled by the header is read.
real=$DATA/real/niivue
[ -d "$real/nifti_space" ] || skip "there is no $real/nifti_space (SC_TEST_DATA)"
"$SEGCAST" convert "$real/aal.nii.gz" -o aal.segc -q >/dev/null
for order in RAS LPS AIL SRP PIR IPL; do
    expect 0 ' grey values .* shown from 2\.' "$SEGCAST" still aal.segc --sheet slices --image "$real/nifti_space/$order.nii.gz" -o $order.png --size 300x240 \
        --set 'animation.clip=[{normal: posterior, at: 40%}]' --set 'tissues={"*": {opacity: 1}}'
    "$IMAGE_DIFFERENCE" RAS.png $order.png 2 0.05 || fail "$order is seen elsewhere than RAS"
done
"$SEGCAST" still aal.segc --sheet slices -o none.png --size 300x240 -q >/dev/null
! "$IMAGE_DIFFERENCE" RAS.png none.png 2 0.05 >/dev/null || fail "the image is not seen"
expect 0 'sheared, by up to 18.50 degrees' "$SEGCAST" still aal.segc --sheet slices --image "$real/shear.nii.gz" -o shear.png --size 300x240
expect 65 'has 2 values for each voxel, expected one: a grey volume' "$SEGCAST" still aal.segc --sheet slices --image "$DATA/real/slicerio/SegmentationOverlapping.seg.nrrd" -o bad.png --size 300x240
