//! A crate's modules: the file of each, and the names that each defines and re-exports.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use syn::{Attribute, Item, UseTree};

/// A module's path in its crate; empty for the root.
pub type ModulePath = Vec<String>;

/// A name that a module hands on: where it comes from.
#[derive(Clone, Debug)]
pub struct HandedOn {
    /// The name by which others know it; none for a glob.
    pub name: Option<String>,
    /// Its path, as written.
    pub path: Vec<String>,
}

/// One module.
#[derive(Clone)]
pub struct Module {
    /// The file that holds it.
    pub file: PathBuf,
    /// Names that it defines.
    pub defines: BTreeSet<String>,
    /// Names that it imports, publicly or not.
    pub uses: Vec<HandedOn>,
    /// Its items, without tests and modules.
    pub items: Vec<Item>,
}

/// The modules of a crate, tests left out.
#[derive(Clone, Default)]
pub struct ModuleTree {
    /// By path.
    pub modules: BTreeMap<ModulePath, Module>,
}

impl ModuleTree {
    /// Reads a crate from its root file.
    ///
    /// # Errors
    /// A file that cannot be read or parsed.
    pub fn read(root: &Path) -> anyhow::Result<Self> {
        let mut tree = Self::default();
        let folder = root.parent().unwrap_or(Path::new("")).to_owned();
        tree.read_file(root, &folder, Vec::new())?;
        Ok(tree)
    }

    /// The crate's files.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let files: BTreeSet<&Path> = self.modules.values().map(|m| m.file.as_path()).collect();
        files.into_iter()
    }

    fn read_file(&mut self, file: &Path, folder: &Path, path: ModulePath) -> anyhow::Result<()> {
        let at = || file.display().to_string();
        let text = fs::read_to_string(file).with_context(at)?;
        let parsed = syn::parse_file(&text).with_context(at)?;
        self.add(file, folder, path, parsed.items)
    }

    /// Adds a module in `file`; modules with separate files are in `folder`.
    fn add(
        &mut self,
        file: &Path,
        folder: &Path,
        path: ModulePath,
        items: Vec<Item>,
    ) -> anyhow::Result<()> {
        let mut module = Module {
            file: file.to_owned(),
            defines: BTreeSet::new(),
            uses: Vec::new(),
            items: Vec::new(),
        };
        for item in items {
            if is_test(attributes(&item)) {
                continue;
            }
            match item {
                Item::Mod(inner) => {
                    let name = inner.ident.to_string();
                    let mut own = path.clone();
                    own.push(name.clone());
                    let below = folder.join(&name);
                    match inner.content {
                        Some((_, items)) => self.add(file, &below, own, items)?,
                        None => {
                            let beside = folder.join(format!("{name}.rs"));
                            let inside = below.join("mod.rs");
                            let found = if beside.is_file() { beside } else { inside };
                            self.read_file(&found, &below, own)?;
                        }
                    }
                }
                Item::Use(used) => flatten(&used.tree, &mut Vec::new(), &mut module.uses),
                other => {
                    module.defines.extend(name_of(&other));
                    module.items.push(other);
                }
            }
        }
        self.modules.insert(path, module);
        Ok(())
    }
}

/// The names of a `use`, each with its whole path.
fn flatten(tree: &UseTree, before: &mut Vec<String>, out: &mut Vec<HandedOn>) {
    let named = |before: &[String], last: String, name: String| {
        let mut path = before.to_vec();
        if last != "self" {
            path.push(last);
        }
        let name = if name == "self" {
            path.last().cloned()
        } else {
            Some(name)
        };
        HandedOn { name, path }
    };
    match tree {
        UseTree::Path(path) => {
            before.push(path.ident.to_string());
            flatten(&path.tree, before, out);
            before.pop();
        }
        UseTree::Name(name) => {
            let name = name.ident.to_string();
            out.push(named(before, name.clone(), name));
        }
        UseTree::Rename(rename) => {
            out.push(named(
                before,
                rename.ident.to_string(),
                rename.rename.to_string(),
            ));
        }
        UseTree::Glob(_) => out.push(HandedOn {
            name: None,
            path: before.clone(),
        }),
        UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, before, out);
            }
        }
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute
                .parse_args::<syn::Path>()
                .is_ok_and(|condition| condition.is_ident("test"))
    })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(i) => &i.ident,
        Item::Enum(i) => &i.ident,
        Item::Fn(i) => &i.sig.ident,
        Item::Macro(i) => i.ident.as_ref()?,
        Item::Static(i) => &i.ident,
        Item::Struct(i) => &i.ident,
        Item::Trait(i) => &i.ident,
        Item::Type(i) => &i.ident,
        Item::Union(i) => &i.ident,
        _ => return None,
    };
    Some(name.to_string())
}
