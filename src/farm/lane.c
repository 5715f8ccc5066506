/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include <pthread.h>

typedef struct queue {
    sc_lane_job *first, **last;
} queue;

struct sc_lane {
    sc_lane_fn *work;
    void *user;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t given;
    queue waiting, done;
    int load;
    double began_s; /* of the job in work, or 0 */
    bool stopping;
    double idle_s;
};

static void enqueue(queue *q, sc_lane_job *job)
{
    job->next = NULL;
    *q->last = job;
    q->last = &job->next;
}

static sc_lane_job *dequeue(queue *q)
{
    sc_lane_job *job = q->first;

    if (job) {
        q->first = job->next;
        if (!q->first)
            q->last = &q->first;
    }
    return job;
}

static void *work_all(void *user)
{
    sc_lane *lane = user;
    double idle_since_s = sc_wall_s();

    pthread_mutex_lock(&lane->lock);
    for (;;) {
        sc_lane_job *job;

        while (!lane->waiting.first && !lane->stopping)
            pthread_cond_wait(&lane->given, &lane->lock);
        job = dequeue(&lane->waiting);
        lane->began_s = sc_wall_s();
        lane->idle_s += lane->began_s - idle_since_s;
        if (!job)
            break;
        job->waited_s = lane->began_s - idle_since_s;
        pthread_mutex_unlock(&lane->lock);
        lane->work(lane->user, job);
        pthread_mutex_lock(&lane->lock);
        idle_since_s = sc_wall_s();
        job->wall_s = idle_since_s - lane->began_s;
        lane->began_s = 0;
        lane->load--;
        enqueue(&lane->done, job);
    }
    pthread_mutex_unlock(&lane->lock);
    return NULL;
}

sc_status sc_lane_start(const sc_ctx *ctx, sc_lane_fn *work, void *user, sc_lane **out)
{
    sc_lane *lane;
    void *block;
    sc_status status = sc_zalloc(ctx, 1, sizeof *lane, &block);

    if (status != SC_OK)
        return status;
    lane = block;
    lane->work = work;
    lane->user = user;
    lane->waiting.last = &lane->waiting.first;
    lane->done.last = &lane->done.first;
    pthread_mutex_init(&lane->lock, NULL);
    pthread_cond_init(&lane->given, NULL);
    if (pthread_create(&lane->thread, NULL, work_all, lane)) {
        sc_free(lane);
        return sc_fail(ctx, SC_ERR_MEMORY, "a thread could not be started");
    }
    *out = lane;
    return SC_OK;
}

void sc_lane_give(sc_lane *lane, sc_lane_job *job)
{
    pthread_mutex_lock(&lane->lock);
    enqueue(&lane->waiting, job);
    lane->load++;
    pthread_cond_signal(&lane->given);
    pthread_mutex_unlock(&lane->lock);
}

sc_lane_job *sc_lane_collect(sc_lane *lane)
{
    sc_lane_job *job;

    pthread_mutex_lock(&lane->lock);
    job = dequeue(&lane->done);
    pthread_mutex_unlock(&lane->lock);
    return job;
}

int sc_lane_load(sc_lane *lane)
{
    int load;

    pthread_mutex_lock(&lane->lock);
    load = lane->load;
    pthread_mutex_unlock(&lane->lock);
    return load;
}

double sc_lane_age_s(sc_lane *lane)
{
    double age_s;

    pthread_mutex_lock(&lane->lock);
    age_s = lane->began_s > 0 ? sc_wall_s() - lane->began_s : 0;
    pthread_mutex_unlock(&lane->lock);
    return age_s;
}

double sc_lane_stop(sc_lane *lane)
{
    double idle_s;

    if (!lane)
        return 0;
    pthread_mutex_lock(&lane->lock);
    lane->stopping = true;
    pthread_cond_signal(&lane->given);
    pthread_mutex_unlock(&lane->lock);
    pthread_join(lane->thread, NULL);
    idle_s = lane->idle_s;
    pthread_cond_destroy(&lane->given);
    pthread_mutex_destroy(&lane->lock);
    sc_free(lane);
    return idle_s;
}
