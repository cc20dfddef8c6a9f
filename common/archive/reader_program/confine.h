// What a process gives up before it looks at a file that may be hostile.
//
// Afterwards it can compute, ask for memory up to a limit, read its archive and its questions, and
// write answers. It can't open a file or a socket, start a program or a process, or get any of this
// back: another system call ends it with SIGSYS. Processor time is limited from outside
// (archive/remote/reader_process.h), which this process can't change either.
//
// Under a sanitizer there is no limit of memory, and what its checks and reports need is permitted:
// to open files for reading, to make pipes, and to write to what is open.
#pragma once

#include <cstdint>

namespace sleight::archive::reader_program {

/// Ends this process as soon as the other end of its lifeline is closed, whatever it does then.
/// Throws base::Error where that can't be had.
void end_with_lifeline(int lifeline);

/// From now on. The descriptors are those of messages.h. Throws base::Error where the kernel can't
/// do it, for then nothing may be read. REQUIRES: one thread; all libraries are loaded and started.
void confine(std::uint64_t address_space_bytes);

}  // namespace sleight::archive::reader_program
