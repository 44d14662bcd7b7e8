//! Writes every complete shader module that the library compiles, and those of the comparison as far as they keep to
//! WebGPU, for checking them with other compilers.

use anyhow::Context;
use clap::Parser;
use dual_paraboloid::compare::{baselines, lookup_cost};
use std::path::PathBuf;

/// Write the library's shader modules.
#[derive(Parser)]
struct Arguments {
    /// Folder to write to; made if it isn't there.
    folder: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let Arguments { folder } = Arguments::parse();
    std::fs::create_dir_all(&folder).with_context(|| format!("can't make the folder {}", folder.display()))?;
    let own = dual_paraboloid::wgsl::modules().into_iter().map(|(name, text)| (name.to_owned(), text));
    for (name, text) in own.chain(baselines::modules()).chain(lookup_cost::modules()) {
        let path = folder.join(format!("{name}.wgsl"));
        std::fs::write(&path, text).with_context(|| format!("can't write {}", path.display()))?;
        println!("{}", path.display());
    }
    Ok(())
}
