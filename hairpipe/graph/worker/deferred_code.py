"""Machine code of a compiled function, generated only if its address is asked for.

Numba optimises every function by itself, generates its machine code, and does both again in each function that
contains it. Nobody calls the first code of a function that is only inlined, nor that of the body of a parallel loop,
which is compiled by itself, in the loop over a thread's share, and in the function. Here such a function stays
intermediate code, in memory and in the folder of kernels, and the function that contains it is optimised as a whole.
"""

from typing import Any

KNOWN = (0, 68)
"""Version of numba whose internal classes are patched here; another one compiles as it does by itself."""


def defer_code() -> None:
    """Patch numba's modules of compilation, in place: libraries of functions generate their code when it is needed."""
    import numba
    from numba.core import codegen, compiler

    if numba.version_info[:2] != KNOWN:
        return
    from numba.core.environment import lookup_environment

    class DeferredLibrary(codegen.JITCodeLibrary):
        """A library of functions, which are linked into others as they were written until one of them is called."""

        _pending, _compiled_object = False, None

        def _optimize_final_module(self) -> None:
            """Leave it to `_generate`."""

        def _finalize_final_module(self) -> None:
            """Make code that was read from a file ready; other code is generated now only if it calls itself."""
            if self._compiled_object is not None:
                super()._finalize_final_module()
                return
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = self._pending = True
            if any(name.startswith(codegen.RuntimeLinker.PREFIX) for name in self._globals()):
                self._generate()

        def _generate(self) -> None:
            """Optimise the module and generate its code, with the environments of all functions in it."""
            self._pending = False
            super()._optimize_final_module()
            self._final_module.verify()
            super()._finalize_final_module()
            for name in self._globals():
                environment = lookup_environment(name)
                if environment is not None:
                    self._codegen.set_env(name, environment)  # pyright: ignore[reportAttributeAccessIssue]

        def _globals(self) -> list[str]:
            return [variable.name for variable in self._final_module.global_variables]

        def _defines(self, name: str) -> bool:
            try:
                return not self._final_module.get_function(name).is_declaration
            except NameError:
                return False

        def get_pointer_to_function(self, name: str) -> int:
            """Return the address of a function, 0 where there is none of that name."""
            self._ensure_finalized()
            if self._pending and self._defines(name):
                self._generate()
            return super().get_pointer_to_function(name)

        def serialize_using_object_code(self) -> Any:
            """Give what is kept of the library in a file."""
            return self.serialize_using_bitcode() if self._pending else super().serialize_using_object_code()

    set_env = codegen.JITCPUCodegen.set_env
    define_pipeline = compiler.DefaultPassBuilder.define_parfor_gufunc_pipeline

    def set_env_of_generated(self: Any, name: str, environment: Any) -> None:
        if self._engine.is_symbol_defined(name):
            set_env(self, name, environment)

    def define_without_entries(state: Any) -> Any:
        """Leave out the entries for Python and for C of the body of a parallel loop, which nobody calls."""
        state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        return define_pipeline(state)

    codegen.JITCPUCodegen._library_class = DeferredLibrary
    codegen.JITCPUCodegen.set_env = set_env_of_generated  # pyright: ignore[reportAttributeAccessIssue]
    builder: Any = compiler.DefaultPassBuilder
    builder.define_parfor_gufunc_pipeline = staticmethod(define_without_entries)
