#include "lock.h"
#include "config.h"
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#if VV_HAVE_SECCOMP
#include <seccomp.h>
#endif

#ifndef __has_feature
#define __has_feature(x) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || __has_feature(address_sanitizer) ||               \
    __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SANITIZED 1 /* its shadow is larger than any limit on address space, and it looks around in /proc */
#else
#define SANITIZED 0
#endif

bool import_locks_nothing(void)
{
    return SANITIZED;
}

void import_lock_early(void)
{
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
    syscall(SYS_close_range, 4U, ~0U, 0U); /* where the kernel cannot: all of ours are closed by exec anyway */
    signal(SIGINT, SIG_IGN);               /* the terminal sends it to all; who started us decides */
    signal(SIGXFSZ, SIG_IGN);              /* a temporary file that is too large is an error with a sentence */
    signal(SIGPIPE, SIG_IGN);
}

static void limit(int what, uint64_t most)
{
    struct rlimit now;
    if (getrlimit(what, &now) != 0)
        return;
    const rlim_t value = now.rlim_max < most ? now.rlim_max : (rlim_t)most;
    setrlimit(what, &(struct rlimit){value, value});
}

void import_lock_limits(const vv_limits *limits, uint64_t memory_bytes, int threads)
{
    /* What is counted may be there twice (samples here and shared); code, stacks and what libraries take by themselves
     * come on top. Samples that lie plainly in a file are mapped, and so need room for the file's bytes as well. */
    const uint64_t slack = ((uint64_t)1 << 30) + (uint64_t)threads * ((uint64_t)80 << 20);
    const uint64_t wanted = memory_bytes < UINT64_MAX / 4 ? 3 * memory_bytes + slack : UINT64_MAX;
    if (!SANITIZED)
        limit(RLIMIT_AS, wanted < limits->import_bytes ? wanted : limits->import_bytes);
    limit(RLIMIT_FSIZE, limits->import_spool);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_NOFILE, 1024);
    /* For the whole life of the process; each request is measured by who asked. */
    limit(RLIMIT_CPU, limits->import_seconds < UINT64_MAX / 1000 ? 1000 * limits->import_seconds : UINT64_MAX);
}

#if VV_HAVE_SECCOMP
/* Reading files, memory, threads, time, answering. What is in neither list fails with EPERM. */
static const int allowed[] = {
    SCMP_SYS(read),
    SCMP_SYS(pread64),
    SCMP_SYS(readv),
    SCMP_SYS(preadv),
    SCMP_SYS(lseek),
    SCMP_SYS(close),
    SCMP_SYS(fstat),
    SCMP_SYS(stat),
    SCMP_SYS(lstat),
    SCMP_SYS(newfstatat),
    SCMP_SYS(statx),
    SCMP_SYS(fstatfs),
    SCMP_SYS(statfs),
    SCMP_SYS(access),
    SCMP_SYS(faccessat),
    SCMP_SYS(faccessat2),
    SCMP_SYS(readlink),
    SCMP_SYS(readlinkat),
    SCMP_SYS(getdents64),
    SCMP_SYS(getcwd),
    SCMP_SYS(fadvise64),
    SCMP_SYS(readahead),
    SCMP_SYS(flock),
    SCMP_SYS(dup),
    SCMP_SYS(poll),
    SCMP_SYS(ppoll),
    SCMP_SYS(select),
    SCMP_SYS(pselect6),
    /* writing: to descriptors that are open, which are the socket, shared memory and temporary files */
    SCMP_SYS(write),
    SCMP_SYS(writev),
    SCMP_SYS(pwrite64),
    SCMP_SYS(sendto),
    SCMP_SYS(sendmsg),
    SCMP_SYS(recvfrom),
    SCMP_SYS(recvmsg),
    SCMP_SYS(ftruncate),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(madvise),
    SCMP_SYS(brk),
    SCMP_SYS(mincore),
    SCMP_SYS(msync),
    SCMP_SYS(futex),
    SCMP_SYS(set_robust_list),
    SCMP_SYS(set_tid_address),
    SCMP_SYS(rseq),
    SCMP_SYS(sched_yield),
    SCMP_SYS(sched_getaffinity),
    SCMP_SYS(gettid),
    SCMP_SYS(getpid),
    SCMP_SYS(membarrier),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(getrandom),
    SCMP_SYS(uname),
    SCMP_SYS(sysinfo),
    SCMP_SYS(getuid),
    SCMP_SYS(geteuid),
    SCMP_SYS(getgid),
    SCMP_SYS(getegid),
    SCMP_SYS(getrusage),
    SCMP_SYS(getrlimit),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(clock_getres),
    SCMP_SYS(clock_nanosleep),
    SCMP_SYS(nanosleep),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(times),
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack),
};

/* No reader does any of these: who does is not a reader any more. */
static const int fatal[] = {
    SCMP_SYS(execve),
    SCMP_SYS(execveat),
    SCMP_SYS(fork),
    SCMP_SYS(vfork),
    SCMP_SYS(socket),
    SCMP_SYS(socketpair),
    SCMP_SYS(connect),
    SCMP_SYS(bind),
    SCMP_SYS(listen),
    SCMP_SYS(accept),
    SCMP_SYS(accept4),
    SCMP_SYS(ptrace),
    SCMP_SYS(process_vm_readv),
    SCMP_SYS(process_vm_writev),
    SCMP_SYS(kill),
    SCMP_SYS(tkill),
    SCMP_SYS(rt_sigqueueinfo),
    SCMP_SYS(creat),
    SCMP_SYS(unlink),
    SCMP_SYS(unlinkat),
    SCMP_SYS(rename),
    SCMP_SYS(renameat),
    SCMP_SYS(renameat2),
    SCMP_SYS(link),
    SCMP_SYS(linkat),
    SCMP_SYS(symlink),
    SCMP_SYS(symlinkat),
    SCMP_SYS(mkdir),
    SCMP_SYS(mkdirat),
    SCMP_SYS(rmdir),
    SCMP_SYS(mknod),
    SCMP_SYS(mknodat),
    SCMP_SYS(truncate),
    SCMP_SYS(chmod),
    SCMP_SYS(fchmod),
    SCMP_SYS(fchmodat),
    SCMP_SYS(chown),
    SCMP_SYS(fchown),
    SCMP_SYS(lchown),
    SCMP_SYS(fchownat),
    SCMP_SYS(setxattr),
    SCMP_SYS(chroot),
    SCMP_SYS(pivot_root),
    SCMP_SYS(mount),
    SCMP_SYS(umount2),
    SCMP_SYS(unshare),
    SCMP_SYS(setns),
    SCMP_SYS(bpf),
    SCMP_SYS(perf_event_open),
    SCMP_SYS(userfaultfd),
    SCMP_SYS(io_uring_setup),
    SCMP_SYS(keyctl),
    SCMP_SYS(add_key),
    SCMP_SYS(init_module),
    SCMP_SYS(finit_module),
    SCMP_SYS(kexec_load),
    SCMP_SYS(reboot),
    SCMP_SYS(setuid),
    SCMP_SYS(setgid),
    SCMP_SYS(setreuid),
    SCMP_SYS(setresuid),
    SCMP_SYS(open_by_handle_at),
};

/* A system call that this machine does not have needs no rule. */
static bool add(scmp_filter_ctx filter, uint32_t action, int call, unsigned n, struct scmp_arg_cmp a,
                struct scmp_arg_cmp b)
{
    const int failed = n == 0   ? seccomp_rule_add(filter, action, call, 0)
                       : n == 1 ? seccomp_rule_add(filter, action, call, 1, a)
                                : seccomp_rule_add(filter, action, call, 2, a, b);
    return failed == 0 || failed == -EDOM || failed == -EINVAL;
}

static bool add_each(scmp_filter_ctx filter, uint32_t action, const int *calls, size_t n)
{
    const struct scmp_arg_cmp none = {0};
    bool ok = true;
    for (size_t i = 0; i < n; i++)
        ok = add(filter, action, calls[i], 0, none, none) && ok;
    return ok;
}

/* Files open for reading; or without a name in the folder of temporary files. Whatever would write one that has a name
 * ends the process. */
static bool add_open(scmp_filter_ctx filter, int call, unsigned flags_at)
{
    const uint64_t nameless = O_TMPFILE & ~O_DIRECTORY, all = O_ACCMODE | O_CREAT | O_TRUNC | nameless;
    const struct scmp_arg_cmp none = {0};
    const struct scmp_arg_cmp read_only = {flags_at, SCMP_CMP_MASKED_EQ, all, O_RDONLY};
    const struct scmp_arg_cmp spool = {flags_at, SCMP_CMP_MASKED_EQ, all, O_RDWR | nameless};
    const struct scmp_arg_cmp writes[] = {
        {flags_at, SCMP_CMP_MASKED_EQ, O_ACCMODE, O_WRONLY},
        {flags_at, SCMP_CMP_MASKED_EQ, O_ACCMODE | nameless, O_RDWR},
        {flags_at, SCMP_CMP_MASKED_EQ, O_CREAT, O_CREAT},
        {flags_at, SCMP_CMP_MASKED_EQ, O_TRUNC, O_TRUNC},
    };
    bool ok =
        add(filter, SCMP_ACT_ALLOW, call, 1, read_only, none) && add(filter, SCMP_ACT_ALLOW, call, 1, spool, none);
    for (size_t i = 0; i < sizeof writes / sizeof writes[0]; i++)
        ok = add(filter, SCMP_ACT_KILL_PROCESS, call, 1, writes[i], none) && ok;
    return ok;
}

/* Calls of which a part is harmless. */
static bool add_parts(scmp_filter_ctx filter)
{
    static const uint64_t descriptor_calls[] = {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL,
                                                F_SETFL, F_GETLK,         F_SETLK, F_SETLKW};
    const struct scmp_arg_cmp none = {0};
    const struct scmp_arg_cmp no_code = {2, SCMP_CMP_MASKED_EQ, 4 /* PROT_EXEC */, 0};
    const struct scmp_arg_cmp thread = {0, SCMP_CMP_MASKED_EQ, CLONE_THREAD | CLONE_VM, CLONE_THREAD | CLONE_VM};
    const struct scmp_arg_cmp no_thread = {0, SCMP_CMP_MASKED_EQ, CLONE_THREAD, 0};
    const struct scmp_arg_cmp only_asks = {2, SCMP_CMP_EQ, 0, 0}; /* prlimit64: the new limits */
    const struct scmp_arg_cmp name_thread = {0, SCMP_CMP_EQ, PR_SET_NAME, 0};
    const struct scmp_arg_cmp own = {0, SCMP_CMP_EQ, (scmp_datum_t)getpid(), 0};
    bool ok = add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 1, no_code, none) &&
              add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1, no_code, none) &&
              add(filter, SCMP_ACT_ALLOW, SCMP_SYS(clone), 1, thread, none) &&
              add(filter, SCMP_ACT_KILL_PROCESS, SCMP_SYS(clone), 1, no_thread, none) &&
              add(filter, SCMP_ACT_ALLOW, SCMP_SYS(prlimit64), 1, only_asks, none) &&
              add(filter, SCMP_ACT_ALLOW, SCMP_SYS(prctl), 1, name_thread, none) &&
              add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, own, none); /* abort() */
    for (size_t i = 0; i < sizeof descriptor_calls / sizeof descriptor_calls[0] && ok; i++)
        ok = add(filter, SCMP_ACT_ALLOW, SCMP_SYS(fcntl), 1,
                 (struct scmp_arg_cmp){1, SCMP_CMP_EQ, descriptor_calls[i], 0}, none);
    /* Their flags lie in memory, where a filter does not see them; both have an older way that it does see. */
    return ok && add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0, none, none) &&
           add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(openat2), 0, none, none) &&
           add(filter, SCMP_ACT_ERRNO(ENOTTY), SCMP_SYS(ioctl), 0, none, none);
}

bool import_lock_calls(void)
{
    if (SANITIZED)
        return true;
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    if (!filter)
        return false;
    bool ok = seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1) == 0 &&
              seccomp_attr_set(filter, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS) == 0 &&
              add_each(filter, SCMP_ACT_ALLOW, allowed, sizeof allowed / sizeof allowed[0]) &&
              add_each(filter, SCMP_ACT_KILL_PROCESS, fatal, sizeof fatal / sizeof fatal[0]) && add_parts(filter) &&
              add_open(filter, SCMP_SYS(openat), 2) && add_open(filter, SCMP_SYS(open), 1) && seccomp_load(filter) == 0;
    seccomp_release(filter);
    return ok;
}
#else
bool import_lock_calls(void)
{
    return false;
}
#endif
