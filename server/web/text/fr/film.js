// French: the keys of en/film.js.

export default {
  "film.intro":
    "Choisissez un film de votre propre pendule, ou déposez-le ici. Il reste dans ce navigateur : rien n’en est envoyé. Marquez deux points dont la distance est connue et le pivot, puis les extrémités, image par image ou d’après leur couleur.",
  "film.open": "Choisir un film",
  "film.opening": "Le film est en cours d’ouverture.",
  "film.opened": "{name} : {time} s.",
  "film.again": "{name} : {time} s, avec les marques qu’il avait.",
  "film.kept":
    "Les marques de {name} sont encore là. Choisissez de nouveau le film pour les y voir.",
  "film.refused": "Ce navigateur ne peut pas montrer {name} comme film.",
  "film.mark": "Marquer des points dans le film",
  "film.done": "Terminé",
  "film.picture":
    "Image du film : les flèches déplacent la croix, Maj fait de plus grands pas, Entrée pose la marque, Page suivante et Page précédente mènent à l’image suivante et à la précédente, Suppr enlève la marque, Échap termine",
  "film.roles": "film à marquer",
  "film.tools": "Ce qui est marqué dans le film",
  "film.back": "Image précédente",
  "film.on": "Image suivante",
  "film.tool": "Marque suivante",
  "film.one": "Échelle, première extrémité",
  "film.two": "Échelle, seconde extrémité",
  "film.pivot": "Pivot",
  "film.below": "Un point juste au-dessous du pivot",
  "film.tip": "Extrémité du bras {arm}",
  "film.remove": "Enlever la marque",
  "film.colour": "Suivre une couleur",
  "film.placed": "{what} : {x} {unit} vers la droite, {y} {unit} vers le haut.",
  "film.end": "C’est la dernière image du film.",
  "film.following": "La couleur est suivie. « Terminé » arrête.",
  "film.followed": "L’extrémité {arm} est marquée dans {count} images.",
  "film.lost":
    "La couleur s’est perdue : l’extrémité {arm} est marquée dans {count} images. Continuez là où on la revoit.",
  "film.noColour": "Il y a trop peu de cette couleur ici.",
  "film.metres": "Longueur de l’échelle",
  "film.slow": "Ralenti : combien de fois plus lent",
  "film.rate": "Images dans une seconde du film",
  "film.tolerance": "De combien une couleur peut différer",
  "film.scaled": "{scale} pixels du film font un mètre.",
  "film.unscaled":
    "Sans échelle, les positions sont en pixels ; un ajustement trouve tout de même les longueurs, par la pesanteur.",
  "film.marked": "Marques de l’extrémité du bras {arm} : {count}",
  "film.fit": "Ajuster le pendule",
  "film.save": "Enregistrer en CSV",
  "film.clear": "Enlever toutes les marques des extrémités",
};
