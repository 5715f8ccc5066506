# SPDX-License-Identifier: BSD-3-Clause
# With several ranks the check for files of others is made once, before the volume is read; all ranks leave
# with 73.
small_job job.yaml
sed -i 's/video: none/video: film.mp4/' job.yaml
echo broken >broken.nrrd
mkdir d
echo mine >d/film.mp4
for how in '' --resume --overwrite; do
    # shellcheck disable=SC2086
    expect 73 'd/film.mp4: is a file that was not made by segcast' mpi 2 "$SEGCAST" render job.yaml -o d --set volume=broken.nrrd $how
    one_error
    [ "$(ls -A d)" = film.mp4 ] && [ "$(cat d/film.mp4)" = mine ] || fail "files were changed: $(ls -A d)"
done
