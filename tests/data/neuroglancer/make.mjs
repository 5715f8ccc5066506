// SPDX-License-Identifier: BSD-3-Clause
// Writes the volumes of this folder with the encoders of Neuroglancer 2.40.1 itself (package neuroglancer of npm), and the
// same voxels as labels.nrrd. Run once, inside of the package, by `node make.mjs FOLDER`; the tests read what it has written.
import fs from "node:fs"
import path from "node:path"
import { encodeChannels as encode32 } from "#src/sliceview/compressed_segmentation/encode_uint32.js"
import { encodeChannels as encode64 } from "#src/sliceview/compressed_segmentation/encode_uint64.js"
import { Uint32ArrayBuilder } from "#src/util/uint32array_builder.js"

const folder = process.argv[2]
const size = [20, 14, 9], chunk = [12, 14, 9], block = [8, 8, 8] // x, y, z
const offset = [100, -20, 0], nm = [500, 500, 1250]
const big = 2 ** 32 + 530 // of the volume of 64 bits, in place of 530
const labels = new Uint32Array(size[0] * size[1] * size[2])
function fill(value, [x0, y0, z0], [x1, y1, z1]) {
    for (let z = z0; z < z1; z++)
        for (let y = y0; y < y1; y++)
            for (let x = x0; x < x1; x++) labels[(z * size[1] + y) * size[0] + x] = value
}
fill(17, [2, 2, 1], [9, 12, 6])
fill(530, [9, 1, 2], [19, 8, 8])
fill(3, [4, 4, 6], [12, 11, 9])

function write(name, type) {
    const words = type === "uint64" ? 2 : 1
    const info = {
        "@type": "neuroglancer_multiscale_volume", type: "segmentation", data_type: type, num_channels: 1, segment_properties: "names",
        scales: [{ key: "0", size, resolution: nm, voxel_offset: offset, chunk_sizes: [chunk], encoding: "compressed_segmentation",
                   compressed_segmentation_block_size: block }],
    }
    const ids = [3, 17, words === 2 ? big : 530]
    const names = { "@type": "neuroglancer_segment_properties", inline: { ids: ids.map(String), properties: [
        { id: "label", type: "label", values: ["soma", "nucleus", "cell wall"] }] } }
    fs.mkdirSync(path.join(folder, name, "0"), { recursive: true })
    fs.mkdirSync(path.join(folder, name, "names"), { recursive: true })
    fs.writeFileSync(path.join(folder, name, "info"), JSON.stringify(info))
    fs.writeFileSync(path.join(folder, name, "names", "info"), JSON.stringify(names))
    for (let from = 0; from < size[0]; from += chunk[0]) {
        const to = Math.min(from + chunk[0], size[0]), shape = [to - from, size[1], size[2], 1]
        const raw = new Uint32Array(shape[0] * shape[1] * shape[2] * words)
        let at = 0
        for (let z = 0; z < size[2]; z++)
            for (let y = 0; y < size[1]; y++)
                for (let x = from; x < to; x++) {
                    const label = labels[(z * size[1] + y) * size[0] + x]
                    raw[at++] = label
                    if (words === 2) raw[at++] = label === 530 ? 1 : 0
                }
        const out = new Uint32ArrayBuilder(4096)
        out.clear()
        ;(words === 2 ? encode64 : encode32)(out, block, raw, shape)
        const range = (axis, a, b) => `${a + offset[axis]}-${b + offset[axis]}`
        fs.writeFileSync(path.join(folder, name, "0", [range(0, from, to), range(1, 0, size[1]), range(2, 0, size[2])].join("_")),
                         Buffer.from(out.view.buffer, out.view.byteOffset, out.view.byteLength))
    }
}
write("words_32", "uint32")
write("words_64", "uint64")
fs.writeFileSync(path.join(folder, "labels.nrrd"), Buffer.concat([Buffer.from(
    `NRRD0004\ntype: uint32\ndimension: 3\nspace dimension: 3\nsizes: ${size.join(" ")}\n` +
    "space directions: (0.0005,0,0) (0,0.0005,0) (0,0,0.00125)\nspace origin: (0.05025,-0.00975,0.000625)\nendian: little\nencoding: gzip\n\n"),
    (await import("node:zlib")).gzipSync(Buffer.from(labels.buffer))]))
