/* SPDX-License-Identifier: BSD-3-Clause */
/* A thread that does tasks in the order in which they are given. */
#include "internal.h"

#include <pthread.h>

/* First in, first out; linked through sc_task.next. */
typedef struct task_queue {
    sc_task *first, **last;
} task_queue;

struct sc_worker_thread {
    sc_task_fn *run;
    void *user;
    pthread_t thread;
    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t given; /* a task was given, or the thread is to stop */
    task_queue waiting, done;
    int load;       /* tasks that were given and are not finished */
    double began_s; /* by sc_wall_s: when the present task was begun, or 0 */
    bool stopping;
    double idle_s; /* total time that the thread has waited for a task */
};

/* Both are called with the lock held.
 *
 * Put a task at the end of a queue. */
static void enqueue(task_queue *queue, sc_task *task)
{
    task->next = NULL;
    *queue->last = task;
    queue->last = &task->next;
}

/* @return the first task, removed from the queue, or NULL if that is empty. */
static sc_task *dequeue(task_queue *queue)
{
    sc_task *task = queue->first;

    if (task) {
        queue->first = task->next;
        if (!queue->first)
            queue->last = &queue->first;
    }
    return task;
}

/* The thread's function: does tasks until it is told to stop and none is waiting. The lock is
 * released only while it waits for a task and while it does one. */
static void *run_tasks(void *user)
{
    sc_worker_thread *t = user;
    double idle_since_s = sc_wall_s();

    pthread_mutex_lock(&t->lock);
    for (;;) {
        sc_task *task;

        while (!t->waiting.first && !t->stopping)
            pthread_cond_wait(&t->given, &t->lock);
        task = dequeue(&t->waiting);
        t->began_s = sc_wall_s();
        t->idle_s += t->began_s - idle_since_s;
        if (!task)
            break;
        task->waited_s = t->began_s - idle_since_s;
        pthread_mutex_unlock(&t->lock);
        t->run(t->user, task);
        pthread_mutex_lock(&t->lock);
        idle_since_s = sc_wall_s();
        task->wall_s = idle_since_s - t->began_s;
        t->began_s = 0;
        t->load--;
        enqueue(&t->done, task);
    }
    pthread_mutex_unlock(&t->lock);
    return NULL;
}

sc_status sc_worker_thread_start(const sc_ctx *ctx, sc_task_fn *run, void *user,
                                 sc_worker_thread **out)
{
    sc_worker_thread *t;

    SC_PASS(SC_ZALLOC(ctx, 1, &t));
    t->run = run;
    t->user = user;
    t->waiting.last = &t->waiting.first;
    t->done.last = &t->done.first;
    pthread_mutex_init(&t->lock, NULL);
    pthread_cond_init(&t->given, NULL);
    if (pthread_create(&t->thread, NULL, run_tasks, t)) {
        pthread_cond_destroy(&t->given);
        pthread_mutex_destroy(&t->lock);
        sc_free(t);
        return sc_fail(
            ctx, SC_ERR_SYSTEM,
            "a worker thread could not be started; is the number of threads limited (ulimit -u)?");
    }
    *out = t;
    return SC_OK;
}

void sc_worker_thread_give(sc_worker_thread *thread, sc_task *task)
{
    pthread_mutex_lock(&thread->lock);
    enqueue(&thread->waiting, task);
    thread->load++;
    pthread_cond_signal(&thread->given);
    pthread_mutex_unlock(&thread->lock);
}

sc_task *sc_worker_thread_collect(sc_worker_thread *thread)
{
    sc_task *task;

    pthread_mutex_lock(&thread->lock);
    task = dequeue(&thread->done);
    pthread_mutex_unlock(&thread->lock);
    return task;
}

int sc_worker_thread_load(sc_worker_thread *thread)
{
    int load;

    pthread_mutex_lock(&thread->lock);
    load = thread->load;
    pthread_mutex_unlock(&thread->lock);
    return load;
}

double sc_worker_thread_task_age_s(sc_worker_thread *thread)
{
    double age_s;

    pthread_mutex_lock(&thread->lock);
    age_s = thread->began_s > 0 ? sc_wall_s() - thread->began_s : 0;
    pthread_mutex_unlock(&thread->lock);
    return age_s;
}

double sc_worker_thread_stop(sc_worker_thread *thread)
{
    double idle_s;

    if (!thread)
        return 0;
    pthread_mutex_lock(&thread->lock);
    thread->stopping = true;
    pthread_cond_signal(&thread->given);
    pthread_mutex_unlock(&thread->lock);
    pthread_join(thread->thread, NULL);
    idle_s = thread->idle_s;
    pthread_cond_destroy(&thread->given);
    pthread_mutex_destroy(&thread->lock);
    sc_free(thread);
    return idle_s;
}
