"""Pages that carry out a composition in the browser, compiled to WebAssembly."""
