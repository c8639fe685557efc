// WebAssembly's own exceptions together with threads, for Emscripten 3.1.6 with clang 14; included
// before every file.
//
// A landing pad tells the C++ runtime what it catches through the variable __wasm_lpad_context. The
// runtime's library for threads defines it thread_local, but this clang declares it without that,
// reads another place, and catches nothing. It takes a declaration that is already there, so here
// is the right one. The function keeps it in use.
#pragma once

extern "C" __thread struct {
  int lpad_index;
  char* lsda;
  int selector;
} __wasm_lpad_context;

__attribute__((used)) inline void* s3_landing_pad_context() {
  return &__wasm_lpad_context;
}
