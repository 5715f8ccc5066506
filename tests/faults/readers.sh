# SPDX-License-Identifier: BSD-3-Clause
# Of the calls of malloc and their kin that reading a volume of text or of JSON takes, every FAULT_STEP-th fails: segcast ends
# with 70 or 71 and one message, or reads it all the same; what is no fault of the file is not called one.
[ -e "${FAULT_SHIM:-}" ] || skip "the library that makes calls fail is built on Linux with glibc only, without sanitizers"
step=${FAULT_STEP:-41}
{
    printf '# AmiraMesh 3D ASCII 2.0\ndefine Lattice 2 2 1\nParameters {\n Materials {\n  Exterior { Id 1 }\n  wall { Color 1 0 0, Id 2 }\n }\n'
    printf ' BoundingBox 0 1 0 1 0 1,\n CoordType "uniform"\n}\nLattice { byte Labels } @1\n@1\n0 1 1 0\n'
} >labels.am
mkdir -p labels.n5/s0/0/0
printf '{"pixelResolution": {"unit": "um", "dimensions": [1, 1, 2]}}' >labels.n5/attributes.json
printf '{"dimensions": [2, 2, 1], "blockSize": [2, 2, 1], "dataType": "uint8", "compression": {"type": "raw"}}' >labels.n5/s0/attributes.json
printf '\0\0\0\3\0\0\0\2\0\0\0\2\0\0\0\1\0\1\1\0' >labels.n5/s0/0/0/0

for volume in labels.am labels.n5; do
    rm -f calls*
    LD_PRELOAD=$FAULT_SHIM FAULT_REPORT=calls "$SEGCAST" info $volume --threads 1 >whole.txt 2>stderr.txt || { cat stderr.txt >&2; fail "$volume cannot be read"; }
    calls=$(sed -n 's/^calls alloc //p' calls*)
    [ "$calls" -gt 100 ] || fail "$volume: $calls calls are counted"
    for ((at = 1 + RANDOM % step; at <= calls; at += step)); do
        code=0
        LD_PRELOAD=$FAULT_SHIM FAULT_KIND=alloc FAULT_AT=$at FAULT_ERROR=ENOMEM "$SEGCAST" info $volume --threads 1 >stdout.txt 2>stderr.txt || code=$?
        case $code in
        0) cmp -s whole.txt stdout.txt || fail "$volume, call $at of $calls: another answer" ;;
        70 | 71) one_error ;;
        *) cat stderr.txt >&2; fail "$volume, call $at of $calls: exit code $code, expected 0, 70 or 71" ;;
        esac
    done
done
