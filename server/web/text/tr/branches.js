// Turkish: the keys of en/branches.js.

export default {
  "branches.intro":
    "Genliği büyürken her modun frekansı: salınım kararlıysa düz çizgi, en küçük itme büyüyorsa kesikli çizgi.",
  "branches.running": "Dallar hesaplanıyor.",
  "branches.hint": "Bir dalın noktasına tıklayın ya da aşağıdan seçin: harekete geçirilir.",
  "branches.plot": "Modların frekansı, ne kadar genişçe salındıklarına göre",
  "branches.far": "Şu genliğe kadar izle",
  "branches.over": "Yatay eksen",
  "branches.amplitude": "genlik",
  "branches.energy": "enerji",
  "branches.amplitude.axis": "kolların en büyük açısı, °",
  "branches.energy.axis": "dengenin üstündeki enerji, J",
  "branches.along": "Dalın yörüngesi",
  "branches.begin": "Bu yörüngeyi harekete geçir",
  "branches.moving": "{mode}. modun yörüngesi sahnede hareket ediyor.",
  "branches.stable": "{angle}° kadar, {energy} J: {frequency} Hz, periyot {period} s; kararlı.",
  "branches.unstable":
    "{angle}° kadar, {energy} J: {frequency} Hz, periyot {period} s; kararsız: en küçük itme büyür.",
  "branches.fold": "{mode}. mod, {angle}°: dal geri döner.",
  "branches.branch": "{mode}. mod, {angle}°: başka bir dal onu keser.",
  "branches.symmetry": "{mode}. mod, {angle}°: iki yanı eş olmayan salınımlar ayrılır.",
  "branches.doubling": "{mode}. mod, {angle}°: iki kat periyotlu salınımlar ayrılır.",
  "branches.torus": "{mode}. mod, {angle}°: kararlılığı dönen bir bozuntuyla değişir.",
  "branches.driven.intro":
    "Sarkacın ne kadar genişçe salındığı, sürücüsünün frekansına göre, yarısından iki katına: salınımın kararlı olduğu yerde düz, en küçük itmenin ondan uzaklaştırdığı yerde kesikli çizgi.",
  "branches.driven.name": "Sürücü altındaki salınım",
  "branches.driven.axis": "sürücünün frekansı, Hz",
  "branches.driven.swing": "en uzak kol, yolunun yarısı, °",
  "branches.driven.stable":
    "Sürücü {frequency} Hz: her yana {angle}°, periyot {period} s; kararlı.",
  "branches.driven.unstable":
    "Sürücü {frequency} Hz: her yana {angle}°, periyot {period} s; kararsız: en küçük itme büyür.",
  "branches.driven.none":
    "Dinginliğin yakınında sürücüyle aynı adımda giden bir salınım bulunamadı.",
  "branches.driven.fold": "{frequency} Hz, {angle}°: dal geri döner.",
  "branches.driven.branch": "{frequency} Hz, {angle}°: başka bir dal onu keser.",
  "branches.driven.symmetry":
    "{frequency} Hz, {angle}°: iki yanda aynı olmayan salınımlar ayrılır.",
  "branches.driven.doubling": "{frequency} Hz, {angle}°: iki kat periyotlu salınımlar ayrılır.",
  "branches.driven.torus": "{frequency} Hz, {angle}°: kararlılığı dönen bir bozulmayla değişir.",
};
