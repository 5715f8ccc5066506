/* SPDX-License-Identifier: BSD-3-Clause */
/* The drawing thread of a rank. It never touches MPI; the main thread gives and collects. */
#include "internal.h"

#include <pthread.h>

typedef struct local_job {
    int unit;
    sc_image *image;
    sc_frame_result result;
} local_job;

struct sc_local {
    const sc_farm *farm;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t given;
    local_job waiting[SC_UNITS_AHEAD], done[SC_UNITS_AHEAD]; /* queues, oldest first */
    int waiting_count, done_count, in_work;
    bool stopping;
    double idle_s, render_wall_s, render_cpu_s;
};

static void *draw_all(void *user)
{
    sc_local *local = user;

    pthread_mutex_lock(&local->lock);
    for (;;) {
        const double begin_s = sc_wall_s();
        double wait_s;
        local_job job;

        while (local->waiting_count == 0 && !local->stopping)
            pthread_cond_wait(&local->given, &local->lock);
        wait_s = sc_wall_s() - begin_s;
        local->idle_s += wait_s;
        if (local->waiting_count == 0)
            break;
        job = local->waiting[0];
        for (int i = 1; i < local->waiting_count; i++)
            local->waiting[i - 1] = local->waiting[i];
        local->waiting_count--;
        local->in_work = 1;
        pthread_mutex_unlock(&local->lock);
        sc_farm_draw(local->farm, job.unit, wait_s, job.image, &job.result);
        pthread_mutex_lock(&local->lock);
        local->render_wall_s += job.result.render_wall_s;
        local->render_cpu_s += job.result.render_cpu_s;
        local->in_work = 0;
        local->done[local->done_count++] = job;
    }
    pthread_mutex_unlock(&local->lock);
    return NULL;
}

sc_status sc_local_start(const sc_ctx *ctx, const sc_farm *farm, sc_local **out)
{
    sc_local *local;
    void *block;
    sc_status status = sc_zalloc(ctx, 1, sizeof *local, &block);

    if (status != SC_OK)
        return status;
    local = block;
    local->farm = farm;
    pthread_mutex_init(&local->lock, NULL);
    pthread_cond_init(&local->given, NULL);
    if (pthread_create(&local->thread, NULL, draw_all, local)) {
        sc_free(local);
        return sc_fail(ctx, SC_ERR_MEMORY, "a thread could not be started");
    }
    *out = local;
    return SC_OK;
}

bool sc_local_has_room(sc_local *local)
{
    bool room;

    pthread_mutex_lock(&local->lock);
    room = local->waiting_count + local->in_work + local->done_count < SC_UNITS_AHEAD;
    pthread_mutex_unlock(&local->lock);
    return room;
}

void sc_local_give(sc_local *local, int unit, sc_image *image)
{
    pthread_mutex_lock(&local->lock);
    local->waiting[local->waiting_count++] = (local_job){.unit = unit, .image = image};
    pthread_cond_signal(&local->given);
    pthread_mutex_unlock(&local->lock);
}

bool sc_local_collect(sc_local *local, int *unit, sc_frame_result *result)
{
    bool found;

    pthread_mutex_lock(&local->lock);
    found = local->done_count > 0;
    if (found) {
        *unit = local->done[0].unit;
        *result = local->done[0].result;
        for (int i = 1; i < local->done_count; i++)
            local->done[i - 1] = local->done[i];
        local->done_count--;
    }
    pthread_mutex_unlock(&local->lock);
    return found;
}

void sc_local_stop(sc_local *local, sc_farm_times *times)
{
    if (!local)
        return;
    pthread_mutex_lock(&local->lock);
    local->stopping = true;
    pthread_cond_signal(&local->given);
    pthread_mutex_unlock(&local->lock);
    pthread_join(local->thread, NULL);
    times->idle_s += local->idle_s;
    times->render_wall_s += local->render_wall_s;
    times->render_cpu_s += local->render_cpu_s;
    pthread_cond_destroy(&local->given);
    pthread_mutex_destroy(&local->lock);
    sc_free(local);
}
