// Drops a process's privileges before it reads a file that may be hostile.
//
// Afterwards the process can compute, allocate memory up to a limit, read its archive and
// questions, and write answers. The process can't open a file or a socket, start a program or a
// process, or regain any privilege: any other system call kills it with SIGSYS. The parent process
// limits this process's processor time (archive/remote/reader_process.h), and this process can't
// change the limit.
//
// Under a sanitizer, memory is not limited. The sanitizer's checks and reports are also permitted
// to open files for reading, to make pipes and to write to open descriptors.
#pragma once

#include <cstdint>

namespace sleight::archive::reader_program {

/// Makes the kernel end this process as soon as the other end of the lifeline is closed. Even a
/// process in an endless loop is ended. Throws base::Error if the kernel can't watch the lifeline.
void end_with_lifeline(int lifeline);

/// Confines the process from now on. messages.h defines the descriptors. Throws base::Error if the
/// kernel lacks support; then the archive must not be read. REQUIRES: one thread; all libraries are
/// loaded and started.
void confine(std::uint64_t address_space_bytes);

}  // namespace sleight::archive::reader_program
