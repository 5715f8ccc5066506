/* SPDX-License-Identifier: BSD-3-Clause */
/* mpirun -n N test_prepare_mpi: the ranks prepare a phantom together, and the first prints the hash
 * of what came out. */
#include "segcast/phantom.h"
#include "segcast/prepare.h"

#include <inttypes.h>

/* Make the phantom, prepare it and print the hash. */
static sc_status prepare(const sc_ctx *ctx, sc_comm *comm)
{
    const int size[3] = {97, 90, 101};
    sc_prepare_settings settings = {.smooth = {1, 1, 1}, .local_thickness = true};
    sc_phantom *phantom = NULL;
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    sc_preparation *p = NULL;
    void *block;
    sc_status status;

    SC_TRY(sc_team_open(ctx, comm, 1, NULL, &settings.team));
    SC_TRY(sc_phantom_new(ctx, &phantom));
    SC_TRY(sc_phantom_volume(ctx, phantom, size, 1, &volume));
    SC_TRY(sc_prepare(ctx, &volume, &settings, &p));
    SC_TRY(sc_team_alloc(ctx, settings.team, sc_preparation_bytes(p), 1, &block));
    sc_preparation_pack_together(p, block);
    if (sc_comm_rank(comm) == 0)
        printf("%016" PRIx64 "\n", sc_hash_bytes(block, sc_preparation_bytes(p), 0));
out:
    sc_preparation_free(p);
    sc_phantom_free(phantom);
    sc_team_close(settings.team);
    return status;
}

int main(void)
{
    const sc_ctx ctx = {.write = sc_log_to_stderr};
    sc_comm *comm;
    sc_status status;

    if (sc_comm_open(&ctx, true, &comm) != SC_OK)
        return 70;
    status = prepare(&ctx, comm);
    sc_comm_close(comm);
    return status == SC_OK ? 0 : 1;
}
