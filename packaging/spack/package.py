# SPDX-License-Identifier: BSD-3-Clause
from spack.package import *


class Segcast(CMakePackage):
    """Videos of segmented volumes, ray-cast on CPUs under MPI and OpenMP."""

    # Spack fetches the tarball that tools/tarball of the sources writes; see docs/install.md.
    url = "file:///var/spack/sources/segcast-1.0.0.tar.gz"

    license("BSD-3-Clause")

    version("1.0.0")

    variant("mpi", default=True, description="Draw with several processes")
    variant("hdf5", default=True, description="Read volumes in HDF5")
    variant("dicom", default=False, description="Read DICOM segmentations")
    variant("tests", default=False, description="Build the tests of the sources")

    depends_on("c", type="build")
    depends_on("cxx", type="build", when="+dicom")
    depends_on("cmake@3.22:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("git", type="build", when="+tests")
    depends_on("mpi@3:", when="+mpi")
    depends_on("hdf5@1.10: ~mpi", when="+hdf5")  # a program of its own reads it, which is no rank
    depends_on("dcmtk@3.6.7:", when="+dicom")
    depends_on("ffmpeg@4.4: +libx264")
    depends_on("cairo@1.16: +ft +fc +png")
    depends_on("fontconfig@2.13:")
    depends_on("libpng@1.6:")
    depends_on("jpeg")
    depends_on("libmicrohttpd")
    depends_on("zlib-api")
    depends_on("libyaml@0.2.2:")
    depends_on("jansson@2.13:")
    depends_on("xxhash@0.8:")
    depends_on("teem@1.12:")
    depends_on("nifticlib@3.0:")
    depends_on("expat@2.2:")
    depends_on("libtiff@4.5:")
    depends_on("meshoptimizer@0.18:")
    depends_on("c-blosc@1.21:")
    depends_on("zstd@1.4:")
    depends_on("lz4@1.9:")
    depends_on("cmocka", type="test", when="+tests")

    # What segcast cannot be built or trusted with.
    conflicts("%gcc@:9", msg="segcast is C17 with vectors as of GCC 10")
    conflicts("%clang@:12", msg="segcast is C17 with vectors as of Clang 13")
    conflicts("%intel", msg="the classic compilers of Intel may contract floating-point operations: pictures would differ")
    conflicts("platform=windows", msg="segcast needs a POSIX system")

    def cmake_args(self):
        return [
            self.define("CMAKE_BUILD_TYPE", "Release"),
            self.define_from_variant("SC_ENABLE_MPI", "mpi"),
            self.define("SC_WITH_HDF5", "ON" if self.spec.satisfies("+hdf5") else "OFF"),
            self.define("SC_WITH_DICOM", "ON" if self.spec.satisfies("+dicom") else "OFF"),
            self.define_from_variant("BUILD_TESTING", "tests"),
        ]

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        self.run_test_of("--version")

    def run_test_of(self, *arguments):
        return Executable(join_path(self.prefix.bin, "segcast"))(*arguments, output=str.split, error=str.split)

    def test_version(self):
        """the program names the version of the package"""
        assert f"segcast {self.spec.version}" in self.run_test_of("--version")

    def test_help(self):
        """the first line of the help is that of segcast"""
        assert self.run_test_of("--help").startswith("Usage: segcast COMMAND")

    def test_film(self):
        """a film of the built-in heart is drawn, and every file of it is proven"""
        with open("job.yaml", "w") as job:
            job.write("volume: phantom:59x41x61\noutput: {size: [96, 72], video: a.mp4}\nanimation: {frames: 6}\n")
        self.run_test_of("render", "job.yaml", "-o", "film", "--overwrite", "-q")
        assert "all verified" in self.run_test_of("verify", "film")
