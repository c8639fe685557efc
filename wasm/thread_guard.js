// Linked into the artefact with threads: what core/base/parallel.cpp calls to learn that a thread has trapped.
mergeInto(LibraryManager.library, {
  s3_survives: function (call, argument) {
    try {
      wasmTable.get(call)(argument);
      return 1;
    } catch (error) {
      err(`A thread of the slicer has crashed: ${error}`);
      return 0;
    }
  },
});
